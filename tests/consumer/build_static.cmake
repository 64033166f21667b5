# Builds the project as static libraries, then as install_and_run.cmake.
# -DSOURCE=<source tree> -DGENERATOR=<generator> -DCONFIG=<build type> -DLAUNCHER=<compiler launcher, or nothing>
# -DCONSUMER=<consumer project> -DWORK=<folder to use>
set(BUILD "${WORK}/package")
execute_process(COMMAND "${CMAKE_COMMAND}" -S "${SOURCE}" -B "${BUILD}" -G "${GENERATOR}" "-DCMAKE_BUILD_TYPE=${CONFIG}"
                        "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}" -DBUILD_SHARED_LIBS=OFF -DMODSEARCH_BUILD_TESTS=OFF
                        -DMODSEARCH_BUILD_EXAMPLES=OFF
                COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${BUILD}" --parallel 2 COMMAND_ERROR_IS_FATAL ANY)
set(WORK "${WORK}/installed")
include("${CMAKE_CURRENT_LIST_DIR}/install_and_run.cmake")
