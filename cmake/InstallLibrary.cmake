# Installs library, headers and a package, so that others write find_package(cmpg) and link cmpg::cmpg: the component `library`.
include(CMakePackageConfigHelpers)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/cmpg)
install(TARGETS cmpg_shared EXPORT cmpg
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT library)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/cmpg DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
install(EXPORT cmpg NAMESPACE cmpg:: FILE cmpg-config.cmake DESTINATION ${package} COMPONENT library) # it depends on no other package
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/cmpg-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cmpg-config-version.cmake DESTINATION ${package} COMPONENT library)
