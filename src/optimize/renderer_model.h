// The renderer as the image model of an optimisation.
#pragma once

#include "optimize/image_model.h"

namespace cmpg {

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
