// An image model that shows the images it makes to somebody.
#pragma once

#include "optimize/image_model.h"

namespace cmpg {

class ObservedModel final : public ImageModel {
  public:
    using Observer = std::function<void(std::size_t view, const Image& image)>;
    // `inner` outlives it.
    ObservedModel(ImageModel& inner, Observer observer) : inner_(inner), observer_(std::move(observer)) {}

    std::size_t views() const override { return inner_.views(); }
    std::pair<int, int> size(std::size_t view) const override { return inner_.size(view); }
    Image render(std::size_t view, std::uint32_t spp, const PassKey& key) override {
        Image image = inner_.render(view, spp, key);
        observer_(view, image);
        return image;
    }
    std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        return inner_.reverse(view, spp, key, adjoint, gradients);
    }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { inner_.setParameter(parameter, values); }
    void endStep() override { inner_.endStep(); }
    void publish() override { inner_.publish(); }
    void save(ByteWriter& out) const override { inner_.save(out); }
    void restore(ByteReader& in, std::uint32_t steps) override { inner_.restore(in, steps); }

  private:
    ImageModel& inner_;
    Observer observer_;
};

} // namespace cmpg
