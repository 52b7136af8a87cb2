// The images a window shows, in turns, and the render pass that draws into one of them.
#pragma once

#include "viewer/present/graphics_device.h"

namespace cmpg::viewer {

class Swapchain {
  public:
    explicit Swapchain(const GraphicsDevice& device);

    // The images for the window's size as it is now. False: it has none, minimised for instance. Nothing may be in flight.
    bool fit();
    void outdate() { outdated_ = true; } // the next fit() makes new images whatever the size

    struct Frame {
        vk::Image image;
        vk::raii::ImageView view{nullptr};
        vk::raii::Framebuffer framebuffer{nullptr};
        vk::raii::Semaphore drawn{nullptr};
    };
    // The frame to draw into, which `free` tells when. Null: not now.
    const Frame* acquire(const vk::raii::Semaphore& free);
    void present(); // what was acquired, once its `drawn` says so

    vk::RenderPass renderPass() const { return *renderPass_; }
    vk::Extent2D extent() const { return extent_; }

  private:
    vk::Extent2D wantedExtent(const vk::SurfaceCapabilitiesKHR& capabilities) const;

    const GraphicsDevice& device_;
    vk::SurfaceFormatKHR format_;
    vk::raii::RenderPass renderPass_{nullptr};
    vk::Extent2D extent_;
    vk::raii::SwapchainKHR swapchain_{nullptr};
    std::vector<Frame> frames_;
    std::uint32_t acquired_ = 0;
    bool outdated_ = true;
};

} // namespace cmpg::viewer
