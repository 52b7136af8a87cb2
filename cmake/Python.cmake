# The Python package: the module _cmpg beside the package's own files, in the build as <build>/python/cmpg and in a wheel as cmpg.
find_package(Python 3.10 REQUIRED COMPONENTS Interpreter Development.Module OPTIONAL_COMPONENTS Development.SABIModule)
execute_process(COMMAND ${Python_EXECUTABLE} -m nanobind --cmake_dir OUTPUT_STRIP_TRAILING_WHITESPACE OUTPUT_VARIABLE nanobind_DIR
  RESULT_VARIABLE found ERROR_QUIET)
if(NOT found EQUAL 0)
  message(FATAL_ERROR "${Python_EXECUTABLE} has no nanobind: scripts/python-env makes an environment that has, or set CMPG_PYTHON=OFF")
endif()
find_package(nanobind CONFIG REQUIRED)

# The stable ABI from Python 3.12 on, which older ones lack.
nanobind_add_module(_cmpg STABLE_ABI python/src/module.cpp python/src/ranks.cpp python/src/scene.cpp python/src/renderer.cpp python/src/guide.cpp
  python/src/recovery.cpp)
target_include_directories(_cmpg PRIVATE ${PROJECT_SOURCE_DIR}/include)
target_link_libraries(_cmpg PRIVATE $<LINK_ONLY:cmpg>) # the surface alone: not the flags of the library's own sources
nanobind_add_module(_lab STABLE_ABI python/src/lab.cpp)
target_include_directories(_lab PRIVATE ${PROJECT_SOURCE_DIR}/src ${PROJECT_SOURCE_DIR}/shaders ${PROJECT_SOURCE_DIR}/include)
target_compile_definitions(_lab PRIVATE CMPG_SOURCES GLM_ENABLE_EXPERIMENTAL)
target_link_libraries(_lab PRIVATE $<LINK_ONLY:cmpg_app> nlohmann_json::nlohmann_json)
set(package ${PROJECT_BINARY_DIR}/python/cmpg)
foreach(module _cmpg _lab)
  target_link_options(${module} PRIVATE -Wl,--exclude-libs,ALL)
  target_compile_options(${module} PRIVATE -Wall -Wextra $<$<BOOL:${CMPG_WARNINGS_AS_ERRORS}>:-Werror>)
  set_target_properties(${module} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${package})
endforeach()
nanobind_add_stub(_cmpg_stub MODULE _cmpg OUTPUT ${package}/_cmpg.pyi PYTHON_PATH ${package} DEPENDS _cmpg)
nanobind_add_stub(_lab_stub MODULE _lab OUTPUT ${package}/_lab.pyi PYTHON_PATH ${package} DEPENDS _lab)
file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/python/cmpg/*.py ${PROJECT_SOURCE_DIR}/python/cmpg/py.typed)
file(MAKE_DIRECTORY ${package})
foreach(file IN LISTS files)
  get_filename_component(name ${file} NAME)
  file(CREATE_LINK ${file} ${package}/${name} SYMBOLIC)
endforeach()
install(TARGETS _cmpg _lab LIBRARY DESTINATION cmpg COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${package}/_cmpg.pyi ${package}/_lab.pyi DESTINATION cmpg COMPONENT python EXCLUDE_FROM_ALL)
