# Fails when a row of the front page's table of backends is not what the page of measured tables has.
# cmake -D README=... -D TABLES=... -P copied_figures.cmake
# README: | `backend` | overlap | wrong or open | distance | wrong, open or unsupported |, means of single calls;
# TABLES: its summary, | `backend` | overlap | in batches | wrong | distance | in batches | wrong | ...

# sum(OUT CELL): of all counts in it, as in "447 (+3836), 3011 unsupported"; "-" stays.
function(sum out cell)
  string(REGEX MATCHALL "[0-9]+" counts "${cell}")
  list(JOIN counts "+" counts)
  if(counts)
    math(EXPR cell "${counts}")
  endif()
  set(${out} "${cell}" PARENT_SCOPE)
endfunction()

# cells(OUT ROW): of | a | b |, thousands together.
function(cells out row)
  string(REGEX REPLACE "^\\| *| *\\|$" "" row "${row}")
  string(REGEX REPLACE " *\\| *" ";" row "${row}")
  string(REGEX REPLACE "([0-9]) ([0-9][0-9][0-9])" "\\1\\2" row "${row}")
  set(${out} "${row}" PARENT_SCOPE)
endfunction()

file(STRINGS ${README} rows REGEX "^\\| `[a-z_]+` \\| [0-9]")
file(STRINGS ${TABLES} lines REGEX "^\\| `[a-z_]+` \\| [0-9]")
if(NOT rows)
  message(FATAL_ERROR "no row of figures in ${README}")
endif()
foreach(row IN LISTS rows)
  cells(said "${row}")
  set(measured)
  foreach(line IN LISTS lines)
    cells(fields "${line}")
    list(GET said 0 backend)
    list(GET fields 0 of)
    if(backend STREQUAL of)
      list(GET fields 1 3 4 6 figures)
      set(measured ${backend})
      foreach(figure IN LISTS figures)
        sum(figure "${figure}")
        list(APPEND measured "${figure}")
      endforeach()
    endif()
  endforeach()
  if(NOT said STREQUAL measured)
    message(SEND_ERROR "the front page has ${said}, the tables have ${measured}")
  endif()
endforeach()
