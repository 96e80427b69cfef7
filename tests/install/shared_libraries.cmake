# Builds the core and the engines' backends as shared libraries, installs them, runs the consumer on them, and looks at
# what each library exports.
# cmake -D PROJECT_DIR=... -D WORK_DIR=... -D CONSUMER_DIR=... -D COMPONENTS=a,b -D NM=... -D CXX=... -D LAUNCHER=... -P ...
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR}/prefix ${WORK_DIR}/consumer)
set(options -G Ninja -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_COMPILER=${CXX})
run(${CMAKE_COMMAND} -S ${PROJECT_DIR} -B ${WORK_DIR}/build ${options} -D BUILD_SHARED_LIBS=ON
  -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} -D TOUCHSTONE_WARNINGS_AS_ERRORS=ON
  -D TOUCHSTONE_BUILD_TESTS=OFF -D TOUCHSTONE_BUILD_EXAMPLES=OFF -D TOUCHSTONE_WITH_SCENE_FILES=OFF
  -D TOUCHSTONE_WITH_LIBCCD=OFF -D TOUCHSTONE_WITH_FCL=OFF -D TOUCHSTONE_WITH_MUJOCO=OFF -D TOUCHSTONE_WITH_ASSIMP=OFF -D TOUCHSTONE_WITH_URDF=OFF -D TOUCHSTONE_WITH_SDF=OFF -D TOUCHSTONE_WITH_RECORDER=OFF -D TOUCHSTONE_WITH_CIGI=OFF -D TOUCHSTONE_WITH_GLTF=OFF)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${CMAKE_COMMAND} --install ${WORK_DIR}/build --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/consumer ${options} -D CMAKE_PREFIX_PATH=${WORK_DIR}/prefix
  -D CONSUMER_COMPONENTS=${COMPONENTS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/consumer)
run(${WORK_DIR}/consumer/consumer)

file(GLOB libraries ${WORK_DIR}/prefix/*/libtouchstone_*.so ${WORK_DIR}/prefix/*/*/libtouchstone_*.so)
if(NOT libraries)
  message(FATAL_ERROR "no shared library was installed")
endif()
foreach(library IN LISTS libraries)
  execute_process(COMMAND ${NM} -DC --defined-only ${library} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^\n]+" symbols "${symbols}")
  list(LENGTH symbols count)
  list(FILTER symbols EXCLUDE REGEX "^[0-9a-f]+ . (([a-z -]+ (for|to) )?touchstone::|touchstone_)")
  if(symbols OR count EQUAL 0)
    message(FATAL_ERROR "${library} exports ${count} symbols, among them foreign ones: ${symbols}")
  endif()
endforeach()
