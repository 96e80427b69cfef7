# A library of this project is a component of the package: find_package(touchstone COMPONENTS bullet) and
# `pkg-config touchstone-bullet` give it and what it needs. What was not built is not installed, and not found.

set(TOUCHSTONE_CONFIG_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/touchstone)

# touchstone_library(NAME SOURCES ...): a library target touchstone_NAME, exported as touchstone::NAME.
function(touchstone_library name)
  add_library(touchstone_${name} ${ARGN})
  add_library(touchstone::${name} ALIAS touchstone_${name})
  set_target_properties(touchstone_${name} PROPERTIES EXPORT_NAME ${name} OUTPUT_NAME touchstone_${name})
  get_target_property(type touchstone_${name} TYPE)
  if(type STREQUAL "SHARED_LIBRARY")
    set(symbols ${PROJECT_SOURCE_DIR}/contact_core/exported_symbols.map)
    # Before 1.0 any minor version may change what is linked. No define: the objects are those of a static build.
    set_target_properties(touchstone_${name} PROPERTIES VERSION ${PROJECT_VERSION}
      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR} DEFINE_SYMBOL "" LINK_DEPENDS ${symbols})
    if(TOUCHSTONE_LINKER_HIDES_SYMBOLS)
      target_link_options(touchstone_${name} PRIVATE LINKER:--version-script=${symbols})
    endif()
    set_target_properties(touchstone_${name} PROPERTIES INSTALL_RPATH "$ORIGIN")
  endif()
  target_include_directories(touchstone_${name} PUBLIC
    $<BUILD_INTERFACE:${TOUCHSTONE_INCLUDE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_compile_features(touchstone_${name} PUBLIC cxx_std_20)
  target_link_libraries(touchstone_${name} PRIVATE $<BUILD_INTERFACE:touchstone_compile_options>)
  set_property(GLOBAL APPEND PROPERTY TOUCHSTONE_COMPONENTS ${name})
endfunction()

# touchstone_component_needs(NAME [COMPONENTS OTHER ...] [ENGINE TITLE DEBIAN PACKAGE ...
#                            [PACKAGE CMAKE_PACKAGE [VERSION]] [LIBRARIES LIBRARY ...] [LINK ITEM ...]] [LANGUAGE C]):
# what a program links besides component NAME. COMPONENTS: further ones of ours; contact_core always is one. ENGINE: whose
# libraries it needs, in words, and the Debian packages that hold them. They are found as a CMake package, or as libraries
# by name; LINK: the targets or libraries that stand for these in this build, where the names do not do. LANGUAGE: of its
# headers' users, C++ otherwise.
function(touchstone_component_needs name)
  cmake_parse_arguments(need "" "ENGINE;LANGUAGE" "COMPONENTS;DEBIAN;PACKAGE;LIBRARIES;LINK" ${ARGN})
  foreach(field COMPONENTS ENGINE DEBIAN PACKAGE LIBRARIES LANGUAGE)
    set_property(GLOBAL PROPERTY TOUCHSTONE_${name}_${field} "${need_${field}}")
  endforeach()
  if(need_LIBRARIES)
    if(NOT need_LINK)
      set(need_LINK ${need_LIBRARIES})
    endif()
    foreach(item IN LISTS need_LINK)
      target_link_libraries(touchstone_${name} PRIVATE $<BUILD_INTERFACE:${item}>)
    endforeach()
    target_link_libraries(touchstone_${name} PRIVATE $<INSTALL_INTERFACE:touchstone::${name}_engine>)
  endif()
endfunction()

# touchstone_install_header(FILE): by its path in this tree.
function(touchstone_install_header file)
  if(TOUCHSTONE_INSTALL)
    get_filename_component(folder ${file} DIRECTORY)
    install(FILES ${PROJECT_SOURCE_DIR}/${file} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/touchstone/${folder}
      COMPONENT development)
  endif()
endfunction()

# touchstone_public_headers(FILES ...): the headers below this folder that users include. They are installed and stand on the
# reference pages (TOUCHSTONE_PUBLIC_HEADERS); every other header is private.
function(touchstone_public_headers)
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  foreach(header IN LISTS ARGN)
    if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${header})
      message(FATAL_ERROR "touchstone: public header is not there: ${folder}/${header}")
    endif()
    set_property(GLOBAL APPEND PROPERTY TOUCHSTONE_PUBLIC_HEADERS ${folder}/${header})
    touchstone_install_header(${folder}/${header})
  endforeach()
endfunction()

# Prepends component NAME and all that it needs to the list LIST, each before what it needs, as static libraries are linked.
function(touchstone_needed_components name list)
  set(needed ${${list}})
  get_property(components GLOBAL PROPERTY TOUCHSTONE_${name}_COMPONENTS)
  if(NOT name STREQUAL "contact_core")
    list(APPEND components contact_core)
  endif()
  foreach(component IN LISTS components)
    if(NOT component IN_LIST needed)
      touchstone_needed_components(${component} needed)
    endif()
  endforeach()
  set(${list} ${name} ${needed} PARENT_SCOPE)
endfunction()

# Writes the files of a component that find_package and pkg-config read.
function(touchstone_write_component name)
  foreach(field COMPONENTS ENGINE DEBIAN PACKAGE LIBRARIES LANGUAGE)
    get_property(TOUCHSTONE_${field} GLOBAL PROPERTY TOUCHSTONE_${name}_${field})
  endforeach()
  set(modules ${TOUCHSTONE_COMPONENTS})
  if(NOT name STREQUAL "contact_core")
    list(APPEND modules contact_core)
  endif()
  list(REMOVE_DUPLICATES modules)
  set(TOUCHSTONE_COMPONENTS ${modules})

  list(TRANSFORM modules PREPEND touchstone-)
  set(libraries ${TOUCHSTONE_LIBRARIES})
  if("${TOUCHSTONE_PACKAGE}" MATCHES "^Eigen3")
    list(APPEND modules eigen3)
  elseif("${TOUCHSTONE_PACKAGE}" MATCHES "^GTest")
    list(APPEND modules gmock)
  elseif("${TOUCHSTONE_PACKAGE}" MATCHES "^Threads")
    list(APPEND libraries pthread)
  endif()
  list(JOIN modules " " TOUCHSTONE_PC_REQUIRES)
  list(TRANSFORM libraries PREPEND -l)
  list(JOIN libraries " " TOUCHSTONE_PC_ENGINE)
  get_target_property(type touchstone_${name} TYPE)
  if(type STREQUAL "SHARED_LIBRARY")  # which links its engine itself
    set(TOUCHSTONE_LIBRARIES)
    set(TOUCHSTONE_PC_PRIVATE ${TOUCHSTONE_PC_ENGINE})
    set(TOUCHSTONE_PC_ENGINE)
  endif()
  get_target_property(definitions touchstone_${name} INTERFACE_COMPILE_DEFINITIONS)
  set(TOUCHSTONE_PC_DEFINITIONS)
  if(definitions)
    list(TRANSFORM definitions PREPEND -D)
    list(JOIN definitions " " TOUCHSTONE_PC_DEFINITIONS)
  endif()
  set(TOUCHSTONE_PC_STANDARD -std=c++20)
  if("${TOUCHSTONE_LANGUAGE}" STREQUAL "C")
    # The modules that it requires would hand their flags for C++ to a compiler of C: what they link stands in their place.
    set(TOUCHSTONE_PC_REQUIRES)
    set(TOUCHSTONE_PC_STANDARD)
    set(needed)
    touchstone_needed_components(${name} needed)
    list(REMOVE_ITEM needed ${name})
    foreach(component IN LISTS needed)
      set(libraries touchstone_${component})
      if(NOT type STREQUAL "SHARED_LIBRARY")
        get_property(engine GLOBAL PROPERTY TOUCHSTONE_${component}_LIBRARIES)
        list(APPEND libraries ${engine})
      endif()
      list(TRANSFORM libraries PREPEND " -l")
      string(APPEND TOUCHSTONE_PC_ENGINE ${libraries})
    endforeach()
  endif()
  set(TOUCHSTONE_COMPONENT ${name})
  file(RELATIVE_PATH TOUCHSTONE_PC_UP /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
  set(folder ${PROJECT_SOURCE_DIR}/contact_core/package)
  configure_file(${folder}/needs.cmake.in ${PROJECT_BINARY_DIR}/package/touchstone-${name}-needs.cmake @ONLY)
  configure_file(${folder}/component.pc.in ${PROJECT_BINARY_DIR}/package/touchstone-${name}.pc @ONLY)
endfunction()

# Installs a library where it was built, with the files that make it a component.
function(touchstone_install_component name)
  install(TARGETS touchstone_${name} EXPORT touchstone-${name}
    LIBRARY OPTIONAL COMPONENT library_${name} NAMELINK_COMPONENT development
    ARCHIVE OPTIONAL COMPONENT development)
  install(EXPORT touchstone-${name} NAMESPACE touchstone:: DESTINATION ${TOUCHSTONE_CONFIG_DIR}
    FILE touchstone-${name}-targets.cmake COMPONENT development)
  set(file ${PROJECT_BINARY_DIR}/package/touchstone-${name})
  install(CODE "
    if(EXISTS \"$<TARGET_FILE:touchstone_${name}>\")
      file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${TOUCHSTONE_CONFIG_DIR}\" TYPE FILE FILES \"${file}-needs.cmake\")
      file(INSTALL DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/pkgconfig\" TYPE FILE FILES \"${file}.pc\")
    else()
      list(APPEND touchstone_not_built ${name})
    endif()" COMPONENT development)
endfunction()

# touchstone_install_program(NAME [DESTINATION FOLDER]): where it was built.
function(touchstone_install_program name)
  if(BUILD_SHARED_LIBS)
    file(RELATIVE_PATH libraries /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
    set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/${libraries}")
  endif()
  if(TOUCHSTONE_INSTALL)
    set_property(GLOBAL APPEND PROPERTY TOUCHSTONE_INSTALLED_PROGRAMS ${name})
    install(TARGETS ${name} RUNTIME ${ARGN} OPTIONAL COMPONENT programs)
  endif()
endfunction()

# touchstone_program(NAME SUMMARY [FOLDERS FOLDER ...]): a program that is installed with a man page made of what --help
# prints, and with folders of examples/ that it reads.
function(touchstone_program name summary)
  cmake_parse_arguments(arg "" "" "FOLDERS" ${ARGN})
  touchstone_install_program(${name})
  if(NOT TOUCHSTONE_INSTALL OR CMAKE_CROSSCOMPILING)
    return()
  endif()
  add_custom_command(TARGET ${name} POST_BUILD VERBATIM
    COMMAND ${CMAKE_COMMAND} -D PROGRAM=$<TARGET_FILE:${name}> -D SUMMARY=${summary} -D VERSION=${PROJECT_VERSION}
      -D OUTPUT=${PROJECT_BINARY_DIR}/package/${name}.1 -P ${PROJECT_SOURCE_DIR}/contact_core/package/man_page.cmake)
  install(FILES ${PROJECT_BINARY_DIR}/package/${name}.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 OPTIONAL
    COMPONENT programs)
  foreach(folder IN LISTS arg_FOLDERS)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples/${folder}/
      DESTINATION ${CMAKE_INSTALL_DATADIR}/touchstone/examples/${folder} COMPONENT programs)
  endforeach()
endfunction()

# touchstone_package(): called last, when every component is there.
function(touchstone_package)
  get_property(names GLOBAL PROPERTY TOUCHSTONE_COMPONENTS)
  foreach(name IN LISTS names)
    touchstone_write_component(${name})
    touchstone_install_component(${name})
  endforeach()
  configure_package_config_file(contact_core/package/config.cmake.in ${PROJECT_BINARY_DIR}/package/touchstone-config.cmake
    INSTALL_DESTINATION ${TOUCHSTONE_CONFIG_DIR})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/touchstone-config-version.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/package/touchstone-config.cmake
      ${PROJECT_BINARY_DIR}/package/touchstone-config-version.cmake
    DESTINATION ${TOUCHSTONE_CONFIG_DIR} COMPONENT development)
  configure_file(contact_core/package/touchstone.pc.in ${PROJECT_BINARY_DIR}/package/touchstone.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/package/touchstone.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT development)

  list(TRANSFORM names PREPEND touchstone_ OUTPUT_VARIABLE targets)
  add_custom_target(libraries DEPENDS ${targets} COMMENT "Every component of the package")
  get_property(programs GLOBAL PROPERTY TOUCHSTONE_INSTALLED_PROGRAMS)
  add_custom_target(installed DEPENDS libraries ${programs} $<TARGET_NAME_IF_EXISTS:touchstone_python>
    COMMENT "All that is installed, but for the reference")
  install(CODE "
    if(touchstone_not_built)
      list(JOIN touchstone_not_built \" \" touchstone_not_built)
      message(\"touchstone: not built, so not installed: \${touchstone_not_built}\\n\"
        \"            (cmake --build ${PROJECT_BINARY_DIR} --target libraries, then install again)\")
    endif()" COMPONENT development)
endfunction()
