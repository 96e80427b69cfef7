# Writes a C++ file that holds text files as string literals, so that a program needs none of them when it runs:
#   cmake -D OUTPUT=FILE.cpp -D FOLDER=FOLDER -D "NAMES=a.css b.js" -D HEADER=HEADER.hpp -D FUNCTION=FUNCTION -P embed_text.cmake
# HEADER declares FUNCTION, named with its namespaces, which gives a file by its name.
cmake_minimum_required(VERSION 3.25)
separate_arguments(NAMES)
set(code "#include \"${HEADER}\"\n\n#include <stdexcept>\n#include <string>\n")
string(APPEND code "\nstd::string_view ${FUNCTION}(std::string_view name) {\n")
foreach(name IN LISTS NAMES)
  file(READ ${FOLDER}/${name} text)
  string(FIND "${text}" ")embedded\"" closing)
  if(NOT closing EQUAL -1)
    message(FATAL_ERROR "${FOLDER}/${name}: holds the mark that ends a literal, )embedded\"")
  endif()
  string(APPEND code "  if (name == \"${name}\") return R\"embedded(${text})embedded\";\n")
endforeach()
string(APPEND code "  throw std::out_of_range(\"not embedded: \" + std::string(name));\n}\n")
file(WRITE ${OUTPUT} "${code}")
