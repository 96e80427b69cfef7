# Makes the pages of a Doxyfile once more, in WORK_DIR, and fails on what Doxygen has to say about them.
# cmake -D DOXYGEN=... -D DOXYFILE=... -D HEADERS=a,b -D NAMESPACES=... -D WORK_DIR=... -D WHAT=... -P check.cmake
# HEADERS: those that the Doxyfile takes in. NAMESPACES: the file with the namespaces' lines.
# WHAT: `warnings`: any warning. `undocumented`: a namespace, class, struct or enumeration, or a function, alias or
# constant of a namespace or file, without a line. Members are free to go without, and so are classes that have none:
# Doxygen does not ask for those. And a header whose head says something (comments before its first declaration) that
# Doxygen does not take for documentation.
file(MAKE_DIRECTORY ${WORK_DIR})
file(READ ${DOXYFILE} settings)
set(warn_if_undocumented NO)
if(WHAT STREQUAL "undocumented")
  set(warn_if_undocumented YES)
endif()
file(WRITE ${WORK_DIR}/Doxyfile "${settings}
OUTPUT_DIRECTORY = \"${WORK_DIR}\"
WARN_LOGFILE = \"${WORK_DIR}/warnings\"
WARN_IF_UNDOCUMENTED = ${warn_if_undocumented}
WARN_AS_ERROR = NO
")
execute_process(COMMAND ${DOXYGEN} ${WORK_DIR}/Doxyfile OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(STRINGS ${WORK_DIR}/warnings found)

if(WHAT STREQUAL "undocumented")
  list(FILTER found INCLUDE REGEX
    "Compound .* is not documented|[(]enumeration[)] of .* is not documented| of (namespace|file) .* is not documented")
  # Of a namespace without a line Doxygen leaves out what is in it, and says nothing.
  file(STRINGS ${NAMESPACES} documented REGEX "^/// @namespace ")
  list(TRANSFORM documented REPLACE "^/// @namespace " "")
  string(REPLACE "," ";" headers "${HEADERS}")
  foreach(header IN LISTS headers)
    file(STRINGS ${header} names REGEX "^namespace [a-z0-9_:]+ {")
    list(TRANSFORM names REPLACE "^namespace ([a-z0-9_:]+) .*" "\\1")
    list(REMOVE_ITEM names ${documented})
    foreach(name IN LISTS names)
      list(APPEND found "${header}: Namespace ${name} is not documented.")
    endforeach()
    file(STRINGS ${header} comments REGEX "^//")
    file(STRINGS ${header} blocks REGEX "^/// @file")
    if(comments AND NOT blocks)
      list(GET comments 0 first)
      if(NOT first MATCHES "^///")
        list(APPEND found "${header}: Head is not documented.")
      endif()
    endif()
  endforeach()
endif()
foreach(line IN LISTS found)
  message(NOTICE "${line}")
endforeach()
if(found)
  message(FATAL_ERROR "${WHAT}: see above")
endif()
