// An image in the memory of the device that draws.
#pragma once

#include "viewer/present/graphics_device.h"

#include <cmpg/image.h>

namespace cmpg::viewer {

class Texture {
  public:
    // For images of this shape; larger ones than the device takes are thinned out.
    Texture(const GraphicsDevice& device, const Image& shape);

    bool fits(const Image& image) const;
    void set(const Image& image); // what record() uploads; nothing that reads the texture may be in flight
    void record(const vk::raii::CommandBuffer& commands);
    vk::ImageView view() const { return *view_; }
    int width() const { return width_; }
    int height() const { return height_; }

  private:
    int stride_;                  // every so many texels of the image one here
    int imageWidth_, imageHeight_; // of the image it stands for
    int width_, height_, imageChannels_, channels_; // channels: 1 or 4, as devices sample them
    vk::raii::DeviceMemory memory_{nullptr}, stagingMemory_{nullptr}; // first: what lies in them goes before them
    vk::raii::Image image_{nullptr};
    vk::raii::Buffer staging_{nullptr};
    vk::raii::ImageView view_{nullptr};
    float* mapped_ = nullptr;
    bool pending_ = false, filled_ = false;
};

} // namespace cmpg::viewer
