# Configures one folder with the options of examples/run, then with those of tests/run: every command that compiles for the
# examples must be one of the tests' too, else each script would compile anew what the other has built.
# cmake -D PROJECT_DIR=... -D WORK_DIR=... -D CXX=... -P shared_objects.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

function(commands_of script result)
  file(STRINGS ${PROJECT_DIR}/${script} lines REGEX "-D TOUCHSTONE_")
  string(REGEX MATCHALL "-D TOUCHSTONE_[A-Z_]+=[A-Z]+" options "${lines}")
  string(REPLACE "-D " "-D" options "${options}")
  run(${CMAKE_COMMAND} -S ${PROJECT_DIR} --preset release -B ${WORK_DIR} --log-level=ERROR
    -D CMAKE_CXX_COMPILER=${CXX} ${options})
  file(STRINGS ${WORK_DIR}/compile_commands.json commands REGEX "\"command\": ")
  set(${result} ${commands} PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
commands_of(examples/run examples)
commands_of(tests/run tests)
list(LENGTH examples count)
list(REMOVE_ITEM examples ${tests})
list(LENGTH examples different)
if(different OR count LESS 100)
  list(GET examples 0 first)
  message(FATAL_ERROR "${different} of ${count} commands differ, the first: ${first}")
endif()
message("${count} commands, the same in both")
