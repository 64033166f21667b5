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

# What is installed keeps the promises of the public headers: the umbrella header names every one of them, and none
# includes a third-party header other than Eigen's.
file(READ "${WORK}/moved/include/modsearch/modsearch.hpp" umbrella)
file(GLOB_RECURSE headers RELATIVE "${WORK}/moved/include" "${WORK}/moved/include/modsearch/*.hpp")
foreach(header IN LISTS headers)
  if(header MATCHES "^modsearch/(kinematics|problem|solvers|baselines)/" AND NOT umbrella MATCHES "#include <${header}>")
    message(FATAL_ERROR "modsearch.hpp does not include <${header}>")
  endif()
  file(STRINGS "${WORK}/moved/include/${header}" foreign
       REGEX "#include [<\"](fcl|ccd|ompl|ceres|nlopt|Ip|coin|nlohmann|assimp|CLI|fmt|boost)|_internal\\.hpp")
  if(foreign)
    message(FATAL_ERROR "<${header}> shows what should stay inside: ${foreign}")
  endif()
endforeach()

step("${CMAKE_COMMAND}" -S "${CONSUMER}" -B "${WORK}/build" "-DCMAKE_PREFIX_PATH=${WORK}/moved")
step("${CMAKE_COMMAND}" --build "${WORK}/build")
step("${WORK}/build/consumer")
if(EXISTS "${WORK}/moved/bin/modsearch")
  step("${WORK}/moved/bin/modsearch" list solvers)
endif()
file(REMOVE_RECURSE "${WORK}")
