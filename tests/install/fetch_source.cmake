# A user's project takes our source into its build: its sources and ours must compile, and ours include no file of theirs.
# WHOLE (minutes): its program must link and run, and an installation hold theirs alone.
# cmake -D PROJECT_DIR=... -D WORK_DIR=... -D SOURCE=... -D CXX=... -D LAUNCHER=... -D WHOLE=ON|OFF -P fetch_source.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK_DIR}/build -G Ninja -D TOUCHSTONE_SOURCE=${PROJECT_DIR}
  -D CMAKE_CXX_COMPILER=${CXX} -D CMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} --log-level=NOTICE)
set(ours _deps/touchstone-build)
if(WHOLE)
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/build --target stranger)
  run(${WORK_DIR}/build/stranger)
else()
  run(${CMAKE_COMMAND} --build ${WORK_DIR}/build --target CMakeFiles/stranger.dir/stranger.cpp.o
    ${ours}/contact_core/CMakeFiles/touchstone_checks.dir/geometry/pose.cpp.o
    ${ours}/physics/CMakeFiles/touchstone_physics.dir/bodies/rigid_body.cpp.o)
endif()

execute_process(COMMAND ninja -C ${WORK_DIR}/build -t deps OUTPUT_VARIABLE deps COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n\n" ";" objects "${deps}")
foreach(object IN LISTS objects)
  if(object MATCHES "^[^\n]*${ours}" AND object MATCHES "${SOURCE}/")
    message(FATAL_ERROR "ours includes theirs: ${object}")
  endif()
endforeach()

if(WHOLE)
  run(${CMAKE_COMMAND} --install ${WORK_DIR}/build --prefix ${WORK_DIR}/prefix)
  file(GLOB_RECURSE installed RELATIVE ${WORK_DIR}/prefix ${WORK_DIR}/prefix/*)
  if(NOT installed STREQUAL "bin/stranger")
    message(FATAL_ERROR "installed: ${installed}")
  endif()
endif()
