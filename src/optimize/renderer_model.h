// The renderer as the image model of an optimisation.
#pragma once

#include "optimize/image_model.h"
#include "render/guided_passes.h"

namespace cmpg {

// The renderer's images, drawn as `passes` decide. Its RenderConfig::differentiable must be the optimised parameters, in the same order.
class RendererModel final : public ImageModel {
  public:
    // From step `freeze` on the guide stays as it is; without one, whether it learns is for others to say.
    RendererModel(Renderer& renderer, GuidedPasses& passes, std::vector<View> cameras, std::uint32_t freeze = ~0u)
        : renderer_(renderer), passes_(passes), views_(std::move(cameras)), freeze_(freeze), learns_(passes.learning()) {}

    std::size_t views() const override { return views_.size(); }
    std::pair<int, int> size(std::size_t view) const override { return {views_.at(view).width, views_.at(view).height}; }
    ImageHalves renderHalves(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples) override {
        return passes_.renderHalves(views_.at(view), spp, key, difference, samples);
    }
    void setSecondValues(std::uint32_t parameter, std::span<const float> values) override { renderer_.setSecondValues(parameter, values); }
    Sampling imageMethod() const override { return passes_.imageMethod(); }
    double imageVariance(Sampling method) const override { return passes_.imageVariance(method); }
    Image picture(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference) override {
        return passes_.picture(views_.at(view), spp, key, difference);
    }
    std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        return passes_.reverse(views_.at(view), spp, key, adjoint, gradients);
    }
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>& half) override {
        return passes_.reverseHalves(views_.at(view), spp, key, adjoint, gradients, half);
    }
    std::uint64_t reversePart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                              std::vector<std::vector<double>>& gradients) override {
        return passes_.reversePart(views_.at(view), spp, key, adjoint, gradients);
    }
    void tellNoise(const std::vector<std::vector<double>>& half, const std::vector<std::vector<double>>& sum) override { passes_.tellNoise(half, sum); }
    std::uint64_t reverseApart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                               std::vector<std::vector<double>>& gradients, FirstVertices* firstVertices) override {
        return passes_.reverseApart(views_.at(view), spp, key, adjoint, gradients, firstVertices);
    }
    double concentration() const override { return passes_.concentration(); }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { renderer_.setParameter(parameter, values); }
    void endStep() override {
        passes_.endStep();
        if (++step_ >= freeze_)
            passes_.setLearning(false);
    }
    void publish() override { passes_.publish(); }
    void save(ByteWriter& out) const override;
    void restore(ByteReader& in, std::uint32_t steps) override;

  private:
    Renderer& renderer_;
    GuidedPasses& passes_;
    std::vector<View> views_;
    std::uint32_t freeze_, step_ = 0;
    bool learns_; // until then
};

} // namespace cmpg
