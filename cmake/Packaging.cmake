# The installed package: find_package(modsearch CONFIG) gives modsearch::kinematics, ::problem, ::solvers, ::baselines, ::rl, ::study.
install(EXPORT modsearchTargets NAMESPACE modsearch:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch COMPONENT dev)
configure_package_config_file(cmake/modsearchConfig.cmake.in "${PROJECT_BINARY_DIR}/modsearchConfig.cmake"
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/modsearchConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/modsearchConfig.cmake" "${PROJECT_BINARY_DIR}/modsearchConfigVersion.cmake"
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch COMPONENT dev)
if(NOT BUILD_SHARED_LIBS)
  install(FILES cmake/Dependencies.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch COMPONENT dev)
endif()
install(FILES modsearch.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/modsearch COMPONENT dev)

# <modsearch/modsearch.hpp> in the build tree, for the examples and tests.
add_library(modsearch_umbrella INTERFACE)
file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include/umbrella/modsearch")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/modsearch.hpp"
     "${PROJECT_BINARY_DIR}/include/umbrella/modsearch/modsearch.hpp" SYMBOLIC)
target_link_libraries(modsearch_umbrella INTERFACE modsearch_study)
target_include_directories(modsearch_umbrella INTERFACE "${PROJECT_BINARY_DIR}/include/umbrella")
