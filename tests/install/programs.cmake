# Programs run from the installed copy, moved elsewhere, read the scenes that came with it, and have man pages.
# cmake -D PREFIX=... -D WORK_DIR=... -P programs.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# RESULT: what PROGRAM --list prints.
function(list_of program result)
  execute_process(COMMAND ${WORK_DIR}/prefix/bin/${program} --list OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
file(COPY ${PREFIX} DESTINATION ${WORK_DIR})
set(examples ${WORK_DIR}/prefix/share/touchstone/examples)
file(RENAME ${examples}/dynamics_run/scenes/sliding_stop.yaml ${examples}/dynamics_run/scenes/of_the_installation.yaml)
file(RENAME ${examples}/training_run/scripts/05_bar.yaml ${examples}/training_run/scripts/05_of_the_installation.yaml)
foreach(program dynamics_run training_run)
  list_of(${program} text)
  if(NOT text MATCHES "of_the_installation")
    message(FATAL_ERROR "${program} reads other files: ${text}")
  endif()
endforeach()
run(${WORK_DIR}/prefix/bin/training_run --scene 05_of_the_installation --out ${WORK_DIR}/training)

list_of(compare_backends text)
if(EXISTS ${WORK_DIR}/prefix/libexec/touchstone/compare_backends_bullet_single AND NOT text MATCHES "bullet_single ")
  message(FATAL_ERROR "compare_backends does not find its worker: ${text}")
endif()

foreach(program compare_backends dynamics_run training_run engine_check)
  file(READ ${WORK_DIR}/prefix/share/man/man1/${program}.1 page)
  if(NOT page MATCHES "^[.]TH ${program} 1 .*[.]SH NAME\n${program} .*[.]SH SYNOPSIS\n${program} .*[.]SH OPTIONS\n")
    message(FATAL_ERROR "the man page of ${program}: ${page}")
  endif()
endforeach()
