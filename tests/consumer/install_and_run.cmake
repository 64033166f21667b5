# Installs the build tree into an empty folder, builds the consumer project against it and runs it.
# -DBUILD=<build tree> -DCONFIG=<build type> -DCONSUMER=<consumer project> -DWORK=<folder to use, emptied first>
function(step)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT status EQUAL 0)
    list(JOIN ARGV " " command)
    message(FATAL_ERROR "Status ${status} of: ${command}")
  endif()
endfunction()

file(REMOVE_RECURSE "${WORK}")
step("${CMAKE_COMMAND}" --install "${BUILD}" --config "${CONFIG}" --prefix "${WORK}/prefix")
# Moved after installation: a package that remembers where it was built or installed is found out.
file(RENAME "${WORK}/prefix" "${WORK}/moved")
step("${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${WORK}/build" "-DCMAKE_PREFIX_PATH=${WORK}/moved")
step("${CMAKE_COMMAND}" --build "${WORK}/build")
step("${WORK}/build/consumer")
if(EXISTS "${WORK}/moved/bin/modsearch")
  step("${WORK}/moved/bin/modsearch" list solvers)
endif()
file(REMOVE_RECURSE "${WORK}")
