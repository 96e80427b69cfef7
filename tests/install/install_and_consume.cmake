# Installs the build tree into a fresh prefix, configures and builds a project against it, runs its program.
# cmake -D BUILD_DIR=... -D WORK_DIR=... -D SOURCE=... -D PROGRAM=... -D CXX=... [-D COMPONENTS=a,b] -P install_and_consume.cmake
# Components come with commas: a semicolon would end the argument in every function call on the way. With COMPONENTS,
# one that was not built must be refused by name.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
set(configure ${CMAKE_COMMAND} -S ${SOURCE} -G Ninja -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_CXX_COMPILER=${CXX} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}")
run(${configure} -B ${WORK_DIR}/build -DCONSUMER_COMPONENTS=${COMPONENTS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/${PROGRAM})

if(COMPONENTS)
  execute_process(COMMAND ${configure} -B ${WORK_DIR}/refused -D CONSUMER_COMPONENTS=no_such_engine
    RESULT_VARIABLE result ERROR_VARIABLE message OUTPUT_QUIET)
  if(result EQUAL 0 OR NOT message MATCHES "no_such_engine")
    message(FATAL_ERROR "an unknown component was not refused by name: ${message}")
  endif()
endif()
