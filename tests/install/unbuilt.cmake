# A build folder in which nothing is built yet, as after a part of a build: cmake --install says what it leaves out and how to
# build it, and find_package does not find it.
# cmake -D PROJECT_DIR=... -D WORK_DIR=... -D CXX=... -P unbuilt.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} -S ${PROJECT_DIR} --preset release -B ${WORK_DIR}/build --log-level=ERROR -D CMAKE_CXX_COMPILER=${CXX}
  -D TOUCHSTONE_BUILD_TESTS=OFF)
execute_process(COMMAND ${CMAKE_COMMAND} --install ${WORK_DIR}/build --prefix ${WORK_DIR}/prefix
  OUTPUT_QUIET ERROR_VARIABLE text RESULT_VARIABLE result)
if(result OR NOT text MATCHES "not built, so not installed: contact_core .* physics" OR NOT text MATCHES "--target libraries")
  message(FATAL_ERROR "result ${result}: ${text}")
endif()

execute_process(COMMAND ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${WORK_DIR}/consumer -G Ninja
    -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix -D CMAKE_CXX_COMPILER=${CXX} -D CONSUMER_COMPONENTS=physics
  RESULT_VARIABLE result ERROR_VARIABLE text OUTPUT_QUIET)
if(result EQUAL 0 OR NOT text MATCHES "component 'contact_core' is not part of this installation")
  message(FATAL_ERROR "result ${result}: ${text}")
endif()
