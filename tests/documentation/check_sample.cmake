# Runs check.cmake on a sample and fails unless it names exactly what the sample lacks.
# cmake -D CHECK=... and what check.cmake takes -P check_sample.cmake
execute_process(COMMAND ${CMAKE_COMMAND} -D DOXYGEN=${DOXYGEN} -D DOXYFILE=${DOXYFILE} -D HEADERS=${HEADERS}
    -D NAMESPACES=${NAMESPACES} -D WORK_DIR=${WORK_DIR} -D WHAT=undocumented -P ${CHECK}
  RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(result EQUAL 0)
  message(FATAL_ERROR "nothing found")
endif()
string(REGEX MATCHALL "[^\n]+ is not documented" lines "${output}")
list(TRANSFORM lines REPLACE ".*(Compound|Member|Namespace) ([a-z_A-Z:]+).*" "\\2")
list(TRANSFORM lines REPLACE ".*: Head is.*" "Head")
list(SORT lines)
set(expected Alias Enumeration Head Inner function kConstant touchstone::Class touchstone::Struct touchstone::Struct::Nested
  touchstone::without_a_line)
if(NOT lines STREQUAL expected)
  message(FATAL_ERROR "found: ${lines}\nexpected: ${expected}")
endif()
