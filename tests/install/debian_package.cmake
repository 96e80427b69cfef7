# Packs the build tree as Debian packages: together they must hold what an installation does, each its copyright and
# changelog; libraries lie where the architecture's do, programs and headers apart; and find_package must find each
# component in what was unpacked. Where lintian is installed, it must find no error and no warning.
# cmake -D BUILD_DIR=... -D PREFIX=... -D WORK_DIR=... -D CONSUMER_DIR=... -D COMPONENTS=a,b -D CPACK=... -D DPKG_DEB=...
#   -D CXX=... -P debian_package.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK_DIR})
# The contents count here, not the size: gzip takes a fraction of xz's time.
run(${CPACK} --config ${BUILD_DIR}/CPackConfig.cmake -G DEB -B ${WORK_DIR} -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip)
file(GLOB packages ${WORK_DIR}/*.deb)
set(root ${WORK_DIR}/root)
foreach(package IN LISTS packages)
  get_filename_component(name ${package} NAME)
  string(REGEX REPLACE "_.*" "" name ${name})
  run(${DPKG_DEB} --extract ${package} ${root})
  foreach(file copyright changelog.gz)
    if(NOT EXISTS ${root}/usr/share/doc/${name}/${file})
      message(FATAL_ERROR "${name} has no ${file}")
    endif()
  endforeach()
  file(REMOVE_RECURSE ${root}/usr/share/doc/${name})
  if(name STREQUAL "python3-touchstone")
    set(python_package ${package})
  endif()
endforeach()

# Python's byte code is in no package and must go with its own. What would clean this machine says what it was told.
if(python_package)
  run(${DPKG_DEB} --control ${python_package} ${WORK_DIR}/control)
  set(told ${WORK_DIR}/told)
  file(WRITE ${WORK_DIR}/bin/py3clean "#!/bin/sh\necho \"$@\" >'${told}'\n")
  file(CHMOD ${WORK_DIR}/bin/py3clean PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  run(${CMAKE_COMMAND} -E env "PATH=${WORK_DIR}/bin:$ENV{PATH}" ${WORK_DIR}/control/prerm remove)
  file(READ ${told} told)
  if(NOT told STREQUAL "-p python3-touchstone\n")
    message(FATAL_ERROR "python3-touchstone's byte code is left: py3clean ${told}")
  endif()
endif()

file(GLOB development ${WORK_DIR}/libtouchstone-dev_*.deb)
execute_process(COMMAND ${DPKG_DEB} --field ${development} Depends OUTPUT_VARIABLE depends COMMAND_ERROR_IS_FATAL ANY)
if(NOT depends MATCHES "libeigen3-dev")
  message(FATAL_ERROR "every header needs Eigen, the package depends on: ${depends}")
endif()
execute_process(COMMAND ${DPKG_DEB} --contents ${development} OUTPUT_VARIABLE held COMMAND_ERROR_IS_FATAL ANY)
if(held MATCHES "/bin/" OR NOT held MATCHES "/usr/include/touchstone/contact_core/registry.hpp")
  message(FATAL_ERROR "libtouchstone-dev holds: ${held}")
endif()

file(GLOB_RECURSE packed RELATIVE ${root}/usr ${root}/*)
file(GLOB_RECURSE installed RELATIVE ${PREFIX} ${PREFIX}/*)
list(TRANSFORM packed REPLACE "(/man1/.*)[.]gz$" "\\1")
list(SORT packed)
list(SORT installed)
if(NOT packed STREQUAL installed)
  set(lacking ${installed})
  list(REMOVE_ITEM lacking ${packed})
  list(REMOVE_ITEM packed ${installed})
  message(FATAL_ERROR "installed and not packed: ${lacking}\npacked and not installed: ${packed}")
endif()

execute_process(COMMAND ${CXX} -print-multiarch OUTPUT_VARIABLE architecture OUTPUT_STRIP_TRAILING_WHITESPACE)
file(GLOB libraries ${root}/usr/lib/${architecture}/libtouchstone_contact_core.*)
if(EXISTS /etc/debian_version AND NOT libraries)
  message(FATAL_ERROR "no library in /usr/lib/${architecture} (in an old build folder: cmake -U CMAKE_INSTALL_LIBDIR)")
endif()

find_program(LINTIAN lintian)
if(LINTIAN)
  run(${LINTIAN} --profile debian --fail-on error,warning ${packages})
endif()

run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${WORK_DIR}/consumer -G Ninja -D CMAKE_PREFIX_PATH=${root}/usr
  -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_COMPILER=${CXX} -D CONSUMER_COMPONENTS=${COMPONENTS})
