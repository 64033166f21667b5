# Two Debian packages by CPack (tools/build_deb): `modsearch`, the programs and the libraries they are made of, and
# `modsearch-dev`, what a program that uses the libraries is compiled with. Two, because whoever only runs the programs
# needs neither a compiler nor Eigen.
set(folder "${PROJECT_SOURCE_DIR}/tools/debian")
set(revision "${PROJECT_VERSION}-1")
file(STRINGS "${folder}/changelog" newest LIMIT_COUNT 1)
if(NOT newest MATCHES "^modsearch \\(${revision}\\) ")
  message(FATAL_ERROR "tools/debian/changelog does not begin with modsearch (${revision}): ${newest}")
endif()

# Debian wants these compressed; without a time stamp (-n) the same sources give the same bytes.
find_program(GZIP gzip REQUIRED)
set(made "${PROJECT_BINARY_DIR}/debian")
file(MAKE_DIRECTORY "${made}")
function(compress source name)
  execute_process(COMMAND "${GZIP}" -9nc "${source}" OUTPUT_FILE "${made}/${name}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()
compress("${folder}/changelog" changelog.Debian.gz)
compress("${PROJECT_SOURCE_DIR}/CHANGELOG.md" changelog.gz)
compress("${folder}/modsearch.1" modsearch.1.gz)
compress("${folder}/modsearch-check.1" modsearch-check.1.gz)

foreach(package modsearch modsearch-dev)
  set(component runtime)
  if(package STREQUAL "modsearch-dev")
    set(component dev)
  endif()
  install(FILES "${folder}/copyright" "${made}/changelog.Debian.gz" "${made}/changelog.gz"
          DESTINATION share/doc/${package} COMPONENT ${component})
  set(overrides "${folder}/${package}.lintian-overrides")
  if(EXISTS "${overrides}")
    install(FILES "${overrides}" DESTINATION share/lintian/overrides RENAME ${package} COMPONENT ${component})
  endif()
endforeach()
install(FILES "${made}/modsearch.1.gz" "${made}/modsearch-check.1.gz" DESTINATION share/man/man1
        COMPONENT runtime)
install(FILES README.md DESTINATION share/doc/modsearch COMPONENT runtime)
install(DIRECTORY docs DESTINATION share/doc/modsearch COMPONENT runtime)
install(DIRECTORY examples/tasks DESTINATION share/doc/modsearch/examples COMPONENT runtime)
file(GLOB examples CONFIGURE_DEPENDS examples/*.cpp)
install(FILES ${examples} DESTINATION share/doc/modsearch-dev/examples COMPONENT dev)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME modsearch)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "design of modular robot arms as a search problem")
set(CPACK_PACKAGE_CONTACT "modsearch developers <developers@modsearch.invalid>" CACHE STRING "Maintainer of the packages")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime dev)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME modsearch)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION science)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "Which modules, in which order, with which lengths, so that an arm reaches its
goals without collision and weighs as little as possible: bounds with proofs,
smooth optimisation, evolution, tree search and reinforcement learning on one
problem interface, a command line, and a program of its own that checks proofs.")
# What the programs are linked with, as dpkg knows it; our own libraries are not installed yet when it is asked.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}")
# CPack's own answer to new libraries is a script that calls ldconfig; Debian's is a trigger. The file shlibs tells what
# a package that is linked with them depends on.
set(shlibs "")
foreach(floor kinematics problem solvers baselines rl study)
  string(APPEND shlibs "libmodsearch_${floor} ${PROJECT_VERSION_MAJOR} modsearch (= ${revision})\n")
endforeach()
file(WRITE "${made}/shlibs" "${shlibs}")
file(WRITE "${made}/triggers" "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${made}/shlibs;${made}/triggers")

set(CPACK_DEBIAN_DEV_PACKAGE_NAME modsearch-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "modsearch (= ${revision}), libeigen3-dev (>= 3.4)")
set(CPACK_COMPONENT_DEV_DESCRIPTION "Headers and the CMake package of the libraries behind modsearch:
find_package(modsearch CONFIG) gives modsearch::baselines and the others.")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)
include(CPack)
