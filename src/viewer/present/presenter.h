// Puts frames into a window: images, and the interface over them. No Vulkan type appears here.
#pragma once

#include "viewer/present/panel_quad.h"

#include <span>
#include <string>

struct GLFWwindow;

namespace cmpg::viewer {

class Presenter {
  public:
    // Needs the context of Dear ImGui, with its fonts. `device`: as --device. Error(Device) where nothing can present in the window.
    Presenter(GLFWwindow* window, const std::string& device);
    ~Presenter();

    // Between them, the interface is built. begin(): false: the window has no area now, and there is nothing to build.
    bool begin();
    void end(std::span<const PanelQuad> quads);
    void fontsChanged(); // between frames

    struct Impl;

  private:
    std::unique_ptr<Impl> impl_;
};

} // namespace cmpg::viewer
