// The image model of a session's optimisation: shows the images it makes.
#pragma once

#include "live/live_work.h"

namespace cmpg {

class LiveWork::Model final : public ImageModel {
  public:
    using Shown = std::function<void(std::size_t view, const Image& image)>;
    Model(RendererModel inner, Shown shown) : inner_(std::move(inner)), shown_(std::move(shown)) {}

    std::size_t views() const override { return inner_.views(); }
    std::pair<int, int> size(std::size_t view) const override { return inner_.size(view); }
    Image render(std::size_t view, std::uint32_t spp, const PassKey& key) override {
        Image image = inner_.render(view, spp, key);
        shown_(view, image);
        return image;
    }
    std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        return inner_.reverse(view, spp, key, adjoint, gradients);
    }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { inner_.setParameter(parameter, values); }
    void endStep() override { inner_.endStep(); }

  private:
    RendererModel inner_;
    Shown shown_;
};

} // namespace cmpg
