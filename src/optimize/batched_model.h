// An image model whose gradients are sampled until their error is small enough.
#pragma once

#include "optimize/batch_parts.h"
#include "optimize/image_model.h"

#include <cmpg/recovery.h>

#include <algorithm>
#include <utility>

namespace cmpg {

class BatchedModel final : public ImageModel {
  public:
    // `inner` outlives it. `budget` is that of one gradient.
    BatchedModel(ImageModel& inner, SampleBudget budget) : inner_(inner), budget_(std::move(budget)) {}

    std::size_t views() const override { return inner_.views(); }
    std::pair<int, int> size(std::size_t view) const override { return inner_.size(view); }
    ImageHalves renderHalves(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples) override {
        return inner_.renderHalves(view, spp, key, difference, samples);
    }
    void setSecondValues(std::uint32_t parameter, std::span<const float> values) override { inner_.setSecondValues(parameter, values); }
    Sampling imageMethod() const override { return inner_.imageMethod(); }
    double imageVariance(Sampling method) const override { return inner_.imageVariance(method); }
    Image picture(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference) override { return inner_.picture(view, spp, key, difference); }
    std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        std::vector<std::vector<double>> ignored;
        return reverseHalves(view, spp, key, adjoint, gradients, ignored);
    }
    // The halves are those of the batches. `half` may be empty.
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>& half) override {
        std::uint64_t paths = 0;
        double samples = 0; // of a batch
        std::vector<std::vector<double>> difference; // half of how those of even and of odd batches differ
        for (const auto& gradient : gradients)
            difference.emplace_back(gradient.size());
        const BudgetedEstimate estimate = spendBudget(budget_, [&](const BatchPart& part) {
            std::vector<std::vector<double>> found;
            found.reserve(gradients.size());
            for (const auto& gradient : gradients)
                found.emplace_back(gradient.size());
            paths += inner_.reversePart(view, part.samples, partKey(key, part, budget_.batches, false), adjoint, found);
            samples += double(part.samples) / budget_.batches;
            const std::uint32_t odd = budget_.batches / 2, even = budget_.batches - odd;
            const double weight = part.batch % 2 == 0 ? 0.5 / even : -0.5 / odd;
            for (std::size_t p = 0; p < difference.size(); ++p)
                for (std::size_t i = 0; i < difference[p].size(); ++i)
                    difference[p][i] += weight * part.samples * found[p][i];
            return joined(found);
        });
        for (auto& entries : difference)
            for (double& entry : entries)
                entry /= samples;
        for (std::size_t p = 0; p < half.size(); ++p)
            for (std::size_t i = 0; i < half[p].size(); ++i)
                half[p][i] += difference[p][i];
        auto next = estimate.mean.begin();
        for (auto& gradient : gradients)
            for (double& entry : gradient)
                entry += *next++;
        inner_.tellNoise(difference, gradients);
        ++step_.gradients;
        if (estimate.end != BudgetedEstimate::End::Error) {
            ++step_.missed;
            step_.worst = std::max(step_.worst, estimate.error.relative);
        }
        return paths;
    }
    std::uint64_t reverseApart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                               std::vector<std::vector<double>>& gradients, FirstVertices* firstVertices) override {
        return inner_.reverseApart(view, spp, key, adjoint, gradients, firstVertices);
    }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { inner_.setParameter(parameter, values); }
    void endStep() override {
        inner_.endStep();
        const Tally step = std::exchange(step_, {});
        whole_ = {whole_.gradients + step.gradients, whole_.missed + step.missed, std::max(whole_.worst, step.worst)};
    }
    void publish() override { inner_.publish(); }
    void save(ByteWriter& out) const override {
        out.put(whole_.gradients);
        out.put(whole_.missed);
        out.put(whole_.worst);
        inner_.save(out);
    }
    void restore(ByteReader& in, std::uint32_t steps) override {
        Tally kept;
        kept.gradients = in.get<std::uint64_t>();
        kept.missed = in.get<std::uint64_t>();
        kept.worst = in.real();
        if (kept.missed > kept.gradients || !(kept.worst >= 0))
            throw Malformed{"its errors are none"};
        inner_.restore(in, steps);
        whole_ = kept;
    }

    void abandonStep() { step_ = {}; } // it ended early
    using Tally = v1::GradientErrors;
    const Tally& tally() const { return whole_; } // of whole steps, those before a restart included

  private:
    ImageModel& inner_;
    SampleBudget budget_;
    Tally whole_, step_; // step_: of the step in flight
};

} // namespace cmpg
