// Draws the images of a frame: textures by image, one pipeline, the colour maps.
#pragma once

#include "viewer/present/panel_quad.h"
#include "viewer/present/texture.h"

#include <map>
#include <span>

namespace cmpg::viewer {

class PanelDrawing {
  public:
    PanelDrawing(const GraphicsDevice& device, vk::RenderPass renderPass);

    // Before the render pass, with nothing in flight: uploads what is new among the images, and forgets those that are not shown.
    void upload(const vk::raii::CommandBuffer& commands, std::span<const PanelQuad> quads);
    // In the render pass.
    void draw(const vk::raii::CommandBuffer& commands, std::span<const PanelQuad> quads, vk::Extent2D window);

  private:
    struct Shown {
        std::shared_ptr<const Image> image; // held, so that no other image gets its address
        Texture texture;
        vk::raii::DescriptorSet set;
    };
    Shown make(const std::shared_ptr<const Image>& image) const;
    vk::raii::DescriptorSet describe(const Texture& texture) const;

    const GraphicsDevice& device_;
    vk::raii::DescriptorSetLayout setLayout_{nullptr};
    vk::raii::DescriptorPool pool_{nullptr};
    vk::raii::PipelineLayout layout_{nullptr};
    vk::raii::Pipeline pipeline_{nullptr};
    std::vector<Shown> shown_, spare_;
    std::unique_ptr<Texture> maps_;
    vk::raii::DescriptorSet mapsSet_{nullptr};
};

} // namespace cmpg::viewer
