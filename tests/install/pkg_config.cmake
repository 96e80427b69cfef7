# Builds SOURCES by what pkg-config says of MODULE in the installed copy, and runs the program.
# cmake -D PREFIX=... -D WORK_DIR=... -D MODULE=... -D SOURCES=a,b [-D DEFINE=...] -D PKG_CONFIG=... -D CXX=... -D CXX_FLAGS=... -P ...
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
file(MAKE_DIRECTORY ${WORK_DIR})
file(GLOB_RECURSE found ${PREFIX}/touchstone.pc)
get_filename_component(folder "${found}" DIRECTORY)
set(ENV{PKG_CONFIG_PATH} ${folder})
execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${MODULE} OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${CXX_FLAGS} ${flags}")
if(DEFINE)
  list(PREPEND flags -D${DEFINE})
endif()
string(REPLACE "," ";" SOURCES "${SOURCES}")
run(${CXX} -o ${WORK_DIR}/program ${SOURCES} ${flags})
run(${WORK_DIR}/program)
