# Writes the man page of a program from what its --help prints.
# cmake -D PROGRAM=... -D SUMMARY=... -D VERSION=... -D OUTPUT=... -P man_page.cmake
get_filename_component(name ${PROGRAM} NAME)
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)

# "Usage: path/name [OPTIONS]" parts what it is for from its options; without that line all of it is the usage.
if(help MATCHES "^(.*)Usage: [^ ]*( [^\n]*)\n\n?(.*)$")
  set(about "${CMAKE_MATCH_1}")
  set(usage "${name}${CMAKE_MATCH_2}")
  set(options "${CMAKE_MATCH_3}")
else()
  set(about "${name} ${SUMMARY}.\n")
  set(usage "${help}")
  set(options)
endif()
foreach(part about usage options SUMMARY)
  string(REPLACE "\\" "\\e" ${part} "${${part}}")
  string(REPLACE "-" "\\-" ${part} "${${part}}")
  string(REGEX REPLACE "(^|\n)([.'])" "\\1\\\\&\\2" ${part} "${${part}}")
endforeach()
string(STRIP "${usage}" usage)
string(REPLACE "\n" "\n.br\n" about "${about}")

set(page ".TH ${name} 1 \"\" \"Touchstone ${VERSION}\" \"Touchstone\"\n")
string(APPEND page ".SH NAME\n${name} \\- ${SUMMARY}\n.SH SYNOPSIS\n${usage}\n.SH DESCRIPTION\n${about}")
if(options)
  string(APPEND page ".SH OPTIONS\n.nf\n${options}.fi\n")
endif()
file(WRITE ${OUTPUT} "${page}")
