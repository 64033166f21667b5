# The installed package: find_package(modsearch CONFIG) gives modsearch::kinematics, ::problem, ::solvers, ::baselines.
install(EXPORT modsearchTargets NAMESPACE modsearch:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch)
configure_package_config_file(cmake/modsearchConfig.cmake.in "${PROJECT_BINARY_DIR}/modsearchConfig.cmake"
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/modsearchConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/modsearchConfig.cmake" "${PROJECT_BINARY_DIR}/modsearchConfigVersion.cmake"
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/modsearch)
install(FILES modsearch.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/modsearch)
