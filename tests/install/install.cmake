# Installs the build tree into a fresh prefix; every component must be there, for find_package and for pkg-config.
# cmake -D BUILD_DIR=... -D PREFIX=... -D COMPONENTS=a;b -P install.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${PREFIX})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${PREFIX})
foreach(component IN LISTS COMPONENTS)
  foreach(file libtouchstone_${component}.* touchstone-${component}-targets.cmake touchstone-${component}.pc)
    file(GLOB_RECURSE found ${PREFIX}/${file})
    if(NOT found)
      message(FATAL_ERROR "not installed: ${file}")
    endif()
  endforeach()
endforeach()
