# The configuration of a project that asks for COMPONENT must end with MESSAGE (a regular expression).
# cmake -D PREFIX=... -D WORK_DIR=... -D COMPONENT=... -D MESSAGE=... -D CXX=... -P refuse.cmake
file(REMOVE_RECURSE ${WORK_DIR})
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${WORK_DIR} -G Ninja
    -D CMAKE_PREFIX_PATH=${PREFIX} -D CMAKE_CXX_COMPILER=${CXX} -D CONSUMER_COMPONENTS=${COMPONENT}
  RESULT_VARIABLE result ERROR_VARIABLE text OUTPUT_QUIET)
if(result EQUAL 0 OR NOT text MATCHES "${MESSAGE}")
  message(FATAL_ERROR "result ${result}, expected: ${MESSAGE}\n${text}")
endif()
