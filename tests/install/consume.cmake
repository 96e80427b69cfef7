# Configures and builds a project against the installed copy, and runs its program.
# cmake -D PREFIX=... -D WORK_DIR=... -D SOURCE=... -D PROGRAM=... -D CXX=... [-D COMPONENTS=a,b] -P consume.cmake
# Components come with commas: a semicolon would end the argument in every function call.
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK_DIR} -G Ninja -D CMAKE_PREFIX_PATH=${PREFIX} -D CMAKE_BUILD_TYPE=Release
  -D CMAKE_CXX_COMPILER=${CXX} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}" -DCONSUMER_COMPONENTS=${COMPONENTS})
run(${CMAKE_COMMAND} --build ${WORK_DIR})
run(${WORK_DIR}/${PROGRAM})
