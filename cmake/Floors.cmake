# A floor is one library target in one folder. It sees the floors it names and no other: each floor has an include
# directory of its own in the build tree that holds nothing but a link to the floor's folder, so an include of a higher
# floor does not compile.
add_library(modsearch_warnings INTERFACE)
target_compile_options(modsearch_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion $<$<BOOL:${MODSEARCH_WARNINGS_AS_ERRORS}>:-Werror>)

# modsearch_floor(<name> SOURCES <files> HEADERS <files> [FLOORS <floors below>] [PUBLIC <targets>] [PRIVATE <targets>])
function(modsearch_floor name)
  cmake_parse_arguments(FLOOR "" "" "SOURCES;HEADERS;FLOORS;PUBLIC;PRIVATE" ${ARGN})
  set(include_dir "${PROJECT_BINARY_DIR}/include/${name}")
  file(MAKE_DIRECTORY "${include_dir}/modsearch")
  file(CREATE_LINK "${CMAKE_CURRENT_SOURCE_DIR}" "${include_dir}/modsearch/${name}" SYMBOLIC)

  add_library(modsearch_${name} ${FLOOR_SOURCES})
  add_library(modsearch::${name} ALIAS modsearch_${name})
  set_target_properties(modsearch_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
  target_compile_features(modsearch_${name} PUBLIC cxx_std_20)
  target_include_directories(modsearch_${name} PUBLIC "$<BUILD_INTERFACE:${include_dir}>"
                             "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
  # Dependencies stay inside a shared library; of a static one they are left to whoever links it.
  if(NOT BUILD_SHARED_LIBS)
    list(TRANSFORM FLOOR_PRIVATE REPLACE "^\\$<BUILD_INTERFACE:([^$>]+)>$" "\\1")
  endif()
  foreach(below IN LISTS FLOOR_FLOORS)
    target_link_libraries(modsearch_${name} PUBLIC modsearch_${below})
  endforeach()
  target_link_libraries(modsearch_${name} PUBLIC ${FLOOR_PUBLIC} PRIVATE ${FLOOR_PRIVATE}
                        $<BUILD_INTERFACE:modsearch_warnings>)
  if(NOT MODSEARCH_SANITIZE)  # clang's sanitizers are linked into programs alone
    target_link_options(modsearch_${name} PRIVATE LINKER:--no-undefined)  # a forgotten source is an error here, not later
  endif()

  install(TARGETS modsearch_${name} EXPORT modsearchTargets
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
          RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT runtime)
  install(FILES ${FLOOR_HEADERS} DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/modsearch/${name}" COMPONENT dev)
endfunction()
