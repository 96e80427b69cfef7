# A file that includes "physics/bodies/rigid_body.hpp" may find a user's of that name first: every include has the prefix, or names
# a file in its own folder, where a compiler looks before anywhere else.
# cmake -D PROJECT_DIR=... -P prefixed_includes.cmake
set(bad)
foreach(folder contact_core adapters physics examples tests)
  file(GLOB_RECURSE sources ${PROJECT_DIR}/${folder}/*.hpp ${PROJECT_DIR}/${folder}/*.cpp)
  foreach(source IN LISTS sources)
    if(source MATCHES "/tests/install/")  # users' own trees
      continue()
    endif()
    get_filename_component(here ${source} DIRECTORY)
    file(STRINGS ${source} includes REGEX "^ *# *include *\"")
    list(FILTER includes EXCLUDE REGEX "\"touchstone/(contact_core|adapters|physics|examples|tests)/")
    foreach(include IN LISTS includes)
      string(REGEX REPLACE ".*\"(.*)\".*" "\\1" file "${include}")
      if(NOT EXISTS ${here}/${file})
        string(APPEND bad "\n${source}: ${include}")
      endif()
    endforeach()
  endforeach()
endforeach()
if(bad)
  message(FATAL_ERROR "without the prefix:${bad}")
endif()
