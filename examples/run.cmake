# -DPROGRAM=<file> -DPRINTS=<regular expression>: fails unless the program ends with status 0 and prints a match.
execute_process(COMMAND "${PROGRAM}" RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
message("${output}${errors}")
if(NOT status EQUAL 0)
  message(FATAL_ERROR "Status ${status} instead of 0.")
elseif(NOT output MATCHES "${PRINTS}")
  message(FATAL_ERROR "The output does not match: ${PRINTS}")
endif()
