# Manual page, completion, desktop entry and icon; and Debian packages of it all: cpack -G DEB in the build folder.
add_executable(write_manual src/manual/write_manual.cpp)
target_link_libraries(write_manual PRIVATE cmpg_app)
target_compile_definitions(write_manual PRIVATE CMPG_VERSION="${PROJECT_VERSION}")
set(manual ${CMAKE_CURRENT_BINARY_DIR}/cmpg-vk.1)
set(completion ${CMAKE_CURRENT_BINARY_DIR}/cmpg-vk.bash)
add_custom_command(OUTPUT ${manual}.gz ${completion} COMMAND write_manual ${manual} ${completion} COMMAND gzip -9nf ${manual} DEPENDS write_manual
  COMMENT "Writing the manual page" VERBATIM)
add_custom_target(manual ALL DEPENDS ${manual}.gz ${completion})
set(packaging ${PROJECT_SOURCE_DIR}/packaging)
install(FILES ${manual}.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT program)
install(FILES ${completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME cmpg-vk COMPONENT program)
install(FILES ${packaging}/cmpg-vk.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT program)
install(FILES ${packaging}/cmpg-vk.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT program)

# Each package with its changelog and the terms of use.
set(components program library)
if(CMPG_MPI)
  list(APPEND components mpi)
endif()
set(package_program cmpg-vk)
set(package_library libcmpg-dev)
set(package_mpi cmpg-vk-mpi)
foreach(component IN LISTS components)
  set(package ${package_${component}})
  set(changelog ${CMAKE_CURRENT_BINARY_DIR}/changelog.${component})
  configure_file(${packaging}/changelog.in ${changelog} @ONLY)
  add_custom_command(OUTPUT ${changelog}.gz COMMAND gzip -9nkf ${changelog} DEPENDS ${changelog} VERBATIM)
  add_custom_target(changelog_${component} ALL DEPENDS ${changelog}.gz)
  add_dependencies(manual changelog_${component})
  install(FILES ${changelog}.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME changelog.gz COMPONENT ${component})
  install(FILES ${packaging}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_FILE_NAME DEB-DEFAULT)
endforeach()

set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON) # packages need no tests
add_custom_target(packages COMMAND ${CMAKE_CPACK_COMMAND} -G DEB DEPENDS cmpg-vk cmpg_shared manual WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} USES_TERMINAL VERBATIM)
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGE_CONTACT "cmpg-vk maintainers <maintainers@cmpg-vk.invalid>")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_PROJECT_CONFIG_FILE ${CMAKE_CURRENT_LIST_DIR}/PackageTools.cmake)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libvulkan1, fonts-dejavu-core") # the loader, which no tool sees; what the window writes with
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "differentiable path tracer that recovers materials from images
Given a glTF or Mitsuba scene and pictures of it, it finds the textures and
colours under which the scene looks like them, on any Vulkan device.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS libvulkan1)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${packaging}/triggers ${packaging}/shlibs)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "differentiable path tracer, as a C++ library
Scenes, devices, images with their derivatives and recoveries, for programs
that do without the command line of cmpg-vk.")
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "cmpg-vk (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_MPI_DESCRIPTION "differentiable path tracer on many machines
The modules with which cmpg-vk shares its work among the ranks of Open MPI
and MPICH.")
include(CPack)
