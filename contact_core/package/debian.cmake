# Debian packages by `cpack -G DEB` in the build folder: libtouchstone-dev (headers, static libraries or links to shared
# ones, CMake and pkg-config files), touchstone-tools (programs, man pages, scenes), python3-touchstone, libtouchstone-doc, and
# with BUILD_SHARED_LIBS one package a library, so that who runs on Bullet needs no MuJoCo. `cmake --workflow --preset package`
# builds and packs all of them.
set(TOUCHSTONE_MAINTAINER "Touchstone team <touchstone@example.org>" CACHE STRING "Who the Debian packages name")
get_property(components GLOBAL PROPERTY TOUCHSTONE_COMPONENTS)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME touchstone)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_NAME} built using CMake")  # CPack's default: each package has its own
set(CPACK_PACKAGE_CONTACT "${TOUCHSTONE_MAINTAINER}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)  # programs and shared libraries; Release has nothing to debug with
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/contact_core/package/debian_files.cmake)

# touchstone_debian_package(COMPONENT PACKAGE SECTION SUMMARY TEXT): the package of an installation's component.
set(CPACK_COMPONENTS_ALL)
set(CPACK_TOUCHSTONE_PACKAGES)
macro(touchstone_debian_package component package section summary text)
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  list(APPEND CPACK_TOUCHSTONE_PACKAGES "${component}=${package}")
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}")
endmacro()

set(about "Touchstone says whether convex hexahedra touch, how far apart or deep
they are, and where, behind one interface for its own check, those of
Bullet, ODE, MuJoCo, FCL and libccd, and an exact one.
.
This package holds")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev (>= 3.4)")
file(WRITE ${PROJECT_BINARY_DIR}/package/triggers "activate-noawait ldconfig\n")
set(suggested)
foreach(component IN LISTS components)
  get_property(engine GLOBAL PROPERTY TOUCHSTONE_${component}_DEBIAN)
  list(APPEND suggested ${engine})
  get_target_property(type touchstone_${component} TYPE)
  if(type STREQUAL "SHARED_LIBRARY")
    string(REPLACE "_" "-" package "libtouchstone-${component}${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
    touchstone_debian_package(library_${component} ${package} libs "contact detection for convex hexahedra: ${component}"
      "${about} the shared library of component\n${component}.")
    string(TOUPPER ${component} upper)
    set(CPACK_DEBIAN_LIBRARY_${upper}_PACKAGE_SHLIBDEPS ON)
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", ${package} (= ${PROJECT_VERSION})")
    string(APPEND CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS ", ${package} (= ${PROJECT_VERSION})")
    get_property(needed GLOBAL PROPERTY TOUCHSTONE_${component}_COMPONENTS)
    if(NOT component STREQUAL "contact_core")
      list(APPEND needed contact_core)
    endif()
    foreach(other IN LISTS needed)
      string(REPLACE "_" "-" other "libtouchstone-${other}${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}")
      string(APPEND CPACK_DEBIAN_LIBRARY_${upper}_PACKAGE_DEPENDS ", ${other} (= ${PROJECT_VERSION})")
    endforeach()
    string(REGEX REPLACE "^, " "" CPACK_DEBIAN_LIBRARY_${upper}_PACKAGE_DEPENDS
      "${CPACK_DEBIAN_LIBRARY_${upper}_PACKAGE_DEPENDS}")
    get_target_property(folder touchstone_${component} BINARY_DIR)
    list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${folder})
    set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
    set(CPACK_DEBIAN_LIBRARY_${upper}_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/package/triggers)
    set(CPACK_POST_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/contact_core/package/debian_scripts.cmake)
  endif()
endforeach()
string(REGEX REPLACE "^, " "" CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS "${CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS}")

touchstone_debian_package(development libtouchstone-dev libdevel "contact detection for convex hexahedra: development files"
  "${about} headers, libraries to link, and files for\nCMake and pkg-config.")
list(REMOVE_DUPLICATES suggested)
list(REMOVE_ITEM suggested libeigen3-dev libc6-dev)
list(JOIN suggested ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS)

if(TOUCHSTONE_BUILD_EXAMPLES)
  touchstone_debian_package(programs touchstone-tools science "contact detection for convex hexahedra: programs"
    "${about} the programs that compare backends on one's\nown pairs and scenes, and fly training scenes.")
  set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
endif()
if(TARGET touchstone_python)
  touchstone_debian_package(python python3-touchstone python "contact detection for convex hexahedra: Python"
    "${about} the Python package touchstone: checks for NumPy's\nbatches, worlds and dynamics.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${PROJECT_SOURCE_DIR}/contact_core/package/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= ${TOUCHSTONE_PYTHON_VERSION}), python3 (<< ${TOUCHSTONE_PYTHON_NEXT}), python3-numpy")
  if(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS)
    string(APPEND CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS ", ${CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS}")
  endif()
endif()
touchstone_debian_package(documentation libtouchstone-doc doc "contact detection for convex hexahedra: reference"
  "${about} the reference pages of every public header.")
set(CPACK_DEBIAN_DOCUMENTATION_PACKAGE_ARCHITECTURE all)
include(CPack)
