# On a machine that has the package but no engine's development files, find_package says which are missing.
# cmake -D PREFIX=... -D WORK_DIR=... -D SOURCE=... -D COMPONENTS=a,b -D NEEDS=a:package,... -D CXX=... -P hide_engines.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK_DIR} -G Ninja -D CMAKE_PREFIX_PATH=${PREFIX} -D CMAKE_CXX_COMPILER=${CXX}
  -D COMPONENTS=${COMPONENTS} -D NEEDS=${NEEDS})
