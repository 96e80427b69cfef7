# Installs the build tree into a fresh prefix, and builds and runs one source with what pkg-config says of it.
# cmake -D BUILD_DIR=... -D WORK_DIR=... -D SOURCE=... -D PKG_CONFIG=... -D CXX=... -D CXX_FLAGS=... -P pkg_config.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
file(GLOB_RECURSE found ${WORK_DIR}/prefix/touchstone.pc)
get_filename_component(folder "${found}" DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${folder})
execute_process(COMMAND ${PKG_CONFIG} --cflags --libs touchstone OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${CXX_FLAGS} ${flags}")
run(${CXX} -O2 -o ${WORK_DIR}/program ${SOURCE} ${flags})
run(${WORK_DIR}/program)
