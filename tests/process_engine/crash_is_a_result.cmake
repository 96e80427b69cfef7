# cmake -D PROGRAM=... -D ENGINE=... -D OUTPUT=... -P crash_is_a_result.cmake: PROGRAM compares an engine that crashes,
# ends well and counts its pair as failed.
execute_process(COMMAND ${PROGRAM} --engine "${ENGINE} crash" --backend native bad --families random --count 100 --quick
    --no-broadphase --output ${OUTPUT}
  RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE errors)
if(NOT result EQUAL 0 OR NOT text MATCHES "\n +distance, 100 pairs\n[^\n]*\n +bad +no place: [0-9]+ missed, 1 failed\n")
  message(FATAL_ERROR "result ${result}, expected: 0 and that distance has 1 failed\n${text}\n${errors}")
endif()
