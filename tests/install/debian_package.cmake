# Packs the build tree as a Debian package: it must hold what an installation does, name what every program needs, and
# find_package must find each component in it, unpacked anywhere.
# cmake -D BUILD_DIR=... -D WORK_DIR=... -D CONSUMER_DIR=... -D COMPONENTS=a,b -D CPACK=... -D DPKG_DEB=... -D CXX=... -P ...
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
run(${CPACK} --config ${BUILD_DIR}/CPackConfig.cmake -G DEB -B ${WORK_DIR})
file(GLOB package ${WORK_DIR}/libtouchstone-dev_*.deb)
execute_process(COMMAND ${DPKG_DEB} --field ${package} Depends OUTPUT_VARIABLE depends COMMAND_ERROR_IS_FATAL ANY)
if(NOT depends MATCHES "libeigen3-dev")
  message(FATAL_ERROR "every header needs Eigen, the package depends on: ${depends}")
endif()

run(${DPKG_DEB} --extract ${package} ${WORK_DIR}/root)
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
file(GLOB_RECURSE packed RELATIVE ${WORK_DIR}/root/usr ${WORK_DIR}/root/*)
file(GLOB_RECURSE installed RELATIVE ${WORK_DIR}/prefix ${WORK_DIR}/prefix/*)
if(NOT packed STREQUAL installed)
  message(FATAL_ERROR "packed: ${packed}\ninstalled: ${installed}")
endif()
if(NOT EXISTS ${WORK_DIR}/root/usr/share/doc/libtouchstone-dev/copyright)
  message(FATAL_ERROR "the package has no copyright file")
endif()

run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/consumer -G Ninja -D CMAKE_PREFIX_PATH=${WORK_DIR}/root/usr
  -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_COMPILER=${CXX} -D CONSUMER_COMPONENTS=${COMPONENTS})
