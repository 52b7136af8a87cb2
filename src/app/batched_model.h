// An image model whose gradients are sampled until their error is small enough.
#pragma once

#include "app/batched_passes.h"
#include "optimize/image_model.h"

#include <algorithm>

namespace cmpg {

class BatchedModel final : public ImageModel {
  public:
    // `inner` outlives it. `budget` is that of one gradient.
    BatchedModel(ImageModel& inner, SampleBudget budget) : inner_(inner), budget_(std::move(budget)) {}

    std::size_t views() const override { return inner_.views(); }
    std::pair<int, int> size(std::size_t view) const override { return inner_.size(view); }
    Image render(std::size_t view, std::uint32_t spp, const PassKey& key) override { return inner_.render(view, spp, key); }
    std::uint64_t reverse(std::size_t view, std::uint32_t, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        std::uint64_t paths = 0;
        const BudgetedEstimate estimate = spendBudget(budget_, [&](const BatchPart& part) {
            std::vector<std::vector<double>> found;
            for (const auto& gradient : gradients)
                found.emplace_back(gradient.size());
            paths += inner_.reverse(view, part.samples, partKey(key, part, budget_.batches, false), adjoint, found);
            return joined(found);
        });
        auto next = estimate.mean.begin();
        for (auto& gradient : gradients)
            for (double& entry : gradient)
                entry += *next++;
        ++gradients_;
        if (estimate.end != BudgetedEstimate::End::Error) {
            ++missed_;
            worst_ = std::max(worst_, estimate.error.relative);
        }
        return paths;
    }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { inner_.setParameter(parameter, values); }
    void endStep() override { inner_.endStep(); }
    void publish() override { inner_.publish(); }
    void save(ByteWriter& out) const override { inner_.save(out); }
    void restore(ByteReader& in, std::uint32_t steps) override { inner_.restore(in, steps); }

    std::uint64_t gradients() const { return gradients_; } // so far
    std::uint64_t missed() const { return missed_; }       // of them, those whose error stayed too large
    double worstError() const { return worst_; }           // of these

  private:
    ImageModel& inner_;
    SampleBudget budget_;
    std::uint64_t gradients_ = 0, missed_ = 0;
    double worst_ = 0;
};

} // namespace cmpg
