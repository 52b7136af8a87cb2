// What an optimisation needs from whatever makes its images: an image and its reverse-mode derivative, per view.
#pragma once

#include "render/renderer.h"

namespace cmpg {

class ImageModel {
  public:
    virtual ~ImageModel() = default;

    virtual std::size_t views() const = 0;
    virtual std::pair<int, int> size(std::size_t view) const = 0; // width, height in pixels
    virtual Image render(std::size_t view, std::uint32_t spp, const PassKey& key) = 0;
    // Adds adjoint^T . dI/dp to `gradients`, one vector of entries() doubles per optimised parameter, in their order. `perPixel` and
    // `weights` as in Renderer::reverse: empty for `spp` everywhere.
    virtual void reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                         std::span<const float> weights, std::vector<std::vector<double>>& gradients) = 0;
    virtual void setParameter(std::uint32_t parameter, std::span<const float> values) = 0;
};

// The renderer's images. Its RenderConfig::differentiable must be the optimised parameters, in the same order.
class RendererModel final : public ImageModel {
  public:
    RendererModel(Renderer& renderer, std::vector<View> cameras) : renderer_(renderer), views_(std::move(cameras)) {}

    std::size_t views() const override { return views_.size(); }
    std::pair<int, int> size(std::size_t view) const override { return {views_.at(view).width, views_.at(view).height}; }
    Image render(std::size_t view, std::uint32_t spp, const PassKey& key) override { return renderer_.render(views_.at(view), spp, key); }
    void reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                 std::span<const float> weights, std::vector<std::vector<double>>& gradients) override {
        renderer_.reverse(views_.at(view), spp, key, adjoint, perPixel, weights, gradients);
    }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { renderer_.setParameter(parameter, values); }

  private:
    Renderer& renderer_;
    std::vector<View> views_;
};

} // namespace cmpg
