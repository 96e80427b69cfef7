# cmake [-D FOLDER=build/compilers] [-D JOBS=2] -P tests/proof/compare_compilers.cmake
#
# Builds result_hash with each compiler, level of optimisation and set of flags below, each in a folder of its own, and
# demands the same hashes from all: answers of the fine check, whole runs of contact worlds and of dynamics.
cmake_minimum_required(VERSION 3.25)
cmake_path(SET root NORMALIZE ${CMAKE_CURRENT_LIST_DIR}/../..)
if(NOT DEFINED FOLDER)
  set(FOLDER ${root}/build/compilers)
endif()
if(NOT DEFINED JOBS)
  set(JOBS 2)
endif()
# NAME|COMPILER|FLAGS
if(NOT DEFINED VARIANTS)
  set(VARIANTS
    "gcc|g++|-O3"
    "gcc-o2-unvectorised|g++|-O2 -DEIGEN_DONT_VECTORIZE"
    "gcc-haswell|g++|-O3 -march=haswell"
    "clang|clang++-14|-O3"
    "clang-o2-unvectorised|clang++-14|-O2 -DEIGEN_DONT_VECTORIZE")
endif()
set(adapters)
foreach(adapter EXACT BULLET ODE LIBCCD FCL MUJOCO SCENE_FILES ASSIMP URDF SDF RECORDER CIGI GLTF)
  list(APPEND adapters -D TOUCHSTONE_WITH_${adapter}=OFF)
endforeach()
foreach(variant IN LISTS VARIANTS)
  string(REPLACE "|" ";" variant "${variant}")
  list(GET variant 0 name)
  list(GET variant 1 compiler)
  list(GET variant 2 flags)
  set(build ${FOLDER}/${name})
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${root} -B ${build} -G Ninja --log-level=WARNING
    -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_CXX_COMPILER_LAUNCHER=ccache -D CMAKE_BUILD_TYPE=Release
    "-DCMAKE_CXX_FLAGS_RELEASE=${flags} -DNDEBUG" -D TOUCHSTONE_BUILD_TESTS=OFF -D TOUCHSTONE_BUILD_EXAMPLES=OFF
    -D TOUCHSTONE_BUILD_RESULT_HASH=ON -D TOUCHSTONE_PRECOMPILED_HEADERS=ON
    ${adapters} COMMAND_ERROR_IS_FATAL ANY OUTPUT_QUIET)
  execute_process(COMMAND ${CMAKE_COMMAND} --build ${build} -j ${JOBS} --target result_hash COMMAND_ERROR_IS_FATAL ANY
    OUTPUT_QUIET)
  execute_process(COMMAND ${build}/tests/proof/result_hash OUTPUT_VARIABLE hashes COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[0-9a-f]+  total[a-z ]*" totals "${hashes}")
  message("${name} (${compiler} ${flags}): ${totals}")
  if(NOT DEFINED expected)
    set(expected "${hashes}")
  elseif(NOT hashes STREQUAL expected)
    message("${hashes}instead of\n${expected}")
    message(FATAL_ERROR "${name} gives other bits than the first")
  endif()
endforeach()
