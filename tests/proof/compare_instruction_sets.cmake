# cmake -D PROGRAMS=result_hash,result_hash_unvectorised -D SETS=generic;avx2 -P compare_instruction_sets.cmake: the same
# hashes from each program under each set.
string(REPLACE "," ";" PROGRAMS "${PROGRAMS}")  # a semicolon would end the argument on the way here
foreach(program IN LISTS PROGRAMS)
  cmake_path(GET program FILENAME name)
  foreach(set IN LISTS SETS)
    set(ENV{TOUCHSTONE_ISA} ${set})
    execute_process(COMMAND ${program} --count 500 OUTPUT_VARIABLE hashes ERROR_VARIABLE settings COMMAND_ERROR_IS_FATAL ANY)
    message("${name}, ${set}: ${settings}${hashes}")
    if(DEFINED expected AND NOT hashes STREQUAL expected)
      message(FATAL_ERROR "${name} under ${set} gives other bits than ${first}")
    elseif(NOT DEFINED expected)
      set(expected "${hashes}")
      set(first "${name} under ${set}")
    endif()
  endforeach()
endforeach()
