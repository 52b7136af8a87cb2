# The window: a module that cmpg-vk loads when it is asked for one. It alone links GLFW and Dear ImGui.
find_package(PkgConfig REQUIRED)
find_package(glfw3 REQUIRED)
pkg_check_modules(IMGUI REQUIRED IMPORTED_TARGET imgui)

# What presents is compiled by itself for the precompiled header of Vulkan, as src/vk is.
file(GLOB CMPG_PRESENT_SOURCES CONFIGURE_DEPENDS src/viewer/present/*.cpp)
add_library(cmpg_present OBJECT ${CMPG_PRESENT_SOURCES})
target_precompile_headers(cmpg_present REUSE_FROM cmpg_vk)
target_link_libraries(cmpg_present PRIVATE cmpg_flags Vulkan::Vulkan glfw PkgConfig::IMGUI)
cmpg_embed_graphics_shaders(cmpg_present ${PROJECT_SOURCE_DIR}/shaders/viewer)

# All of the window but its entry, so that tests can reach it.
file(GLOB CMPG_VIEWER_SOURCES CONFIGURE_DEPENDS src/viewer/*.cpp)
list(REMOVE_ITEM CMPG_VIEWER_SOURCES ${PROJECT_SOURCE_DIR}/src/viewer/viewer_main.cpp)
add_library(cmpg_viewer STATIC ${CMPG_VIEWER_SOURCES} $<TARGET_OBJECTS:cmpg_present>)
set_target_properties(cmpg_viewer PROPERTIES UNITY_BUILD ${CMPG_UNITY})
target_link_libraries(cmpg_viewer PUBLIC cmpg_app glfw PkgConfig::IMGUI Vulkan::Vulkan)

add_library(cmpg-viewer MODULE src/viewer/viewer_main.cpp)
set_target_properties(cmpg-viewer PROPERTIES CXX_VISIBILITY_PRESET hidden)
target_link_libraries(cmpg-viewer PRIVATE cmpg_viewer)
# The program holds the same libraries: the module must use its own copy of them and show nothing but its entry. Debian's Dear ImGui is
# compiled for executables (-fPIE), which binding symbols locally makes fit for a module.
target_link_options(cmpg-viewer PRIVATE -Wl,-Bsymbolic -Wl,--exclude-libs,ALL)
add_dependencies(cmpg-vk cmpg-viewer) # which it loads
install(TARGETS cmpg-viewer LIBRARY DESTINATION ${CMPG_MODULE_FOLDER} COMPONENT program)
