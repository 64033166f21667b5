# Every dependency of the floors as one imported target; what ships without a target gets one here and nowhere else. A
# package of static libraries brings this file along: whoever links them needs all that is inside.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)          # Eigen3::Eigen
find_package(fcl 0.7 REQUIRED)                       # fcl
find_package(Ceres 2.1 REQUIRED)                     # Ceres::ceres
find_package(nlohmann_json 3.11 REQUIRED)            # nlohmann_json::nlohmann_json
find_package(fmt 9 REQUIRED)                         # fmt::fmt
find_package(assimp 5.2 REQUIRED)                    # assimp::assimp

# Ipopt: only its .pc defines HAVE_CSTDDEF, without which the headers of 3.11 do not compile.
pkg_check_modules(IPOPT REQUIRED IMPORTED_TARGET GLOBAL ipopt)
# NLopt: two CMake packages share the name; pkg-config tells them apart.
pkg_check_modules(NLOPT REQUIRED IMPORTED_TARGET GLOBAL nlopt_cxx)
if(NOT TARGET modsearch_ipopt)
  add_library(modsearch_ipopt INTERFACE IMPORTED GLOBAL)
  target_link_libraries(modsearch_ipopt INTERFACE PkgConfig::IPOPT)
  add_library(modsearch_nlopt INTERFACE IMPORTED GLOBAL)
  target_link_libraries(modsearch_nlopt INTERFACE PkgConfig::NLOPT)
endif()

# OMPL 1.5 gives variables, no target. Of its libraries we use OMPL alone; the others (boost_serialization, ode) are what
# OMPL itself was linked with, by paths that are there only where their development packages are installed too.
find_package(ompl 1.5 REQUIRED)
list(FILTER OMPL_LIBRARIES INCLUDE REGEX "/libompl\\.")
if(NOT TARGET modsearch_ompl)
  add_library(modsearch_ompl INTERFACE IMPORTED GLOBAL)
  target_include_directories(modsearch_ompl SYSTEM INTERFACE ${OMPL_INCLUDE_DIR})
  target_link_libraries(modsearch_ompl INTERFACE ${OMPL_LIBRARIES} Eigen3::Eigen)
endif()
