// How much to sample: an estimate made of batches with random numbers of their own, its error, and when there is enough of it.
#pragma once

#include <cmpg/report.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// `batches`: independent, alike, at least 5. Not a number where the mean is zero.
EstimateError errorOf(std::span<const std::vector<float>> batches);

// Samples that one batch gets at once.
struct BatchPart {
    std::uint32_t batch = 0, stage = 0;
    std::uint32_t firstSample = 0, samples = 0; // per pixel
};

// Batches grow together, in stages that double what there is: 1, 1, 2, 4, 8 ... samples per pixel each, the last one cut to fit. Where to
// stop is looked up between stages alone; no other decision depends on the clock, and the samples determine the stages.
struct SampleBudget {
    std::uint32_t batches = 8;
    std::uint32_t samples = 1;     // per pixel, of a batch, at most
    std::optional<double> error{};   // EstimateError::relative that is enough
    std::optional<double> seconds{}; // on the clock, at the end; the first stage runs in any case
    std::function<double()> clock{}; // needed with `seconds`
};

struct BudgetedEstimate {
    using End = BudgetEnd; // what was used up or reached
    End end = End::Samples;
    std::vector<double> mean;
    std::uint32_t samples = 0; // per pixel, of a batch
    EstimateError error;
};
// `pass` returns the mean over a part's samples. `shown`: called after each stage.
BudgetedEstimate spendBudget(const SampleBudget& budget, const std::function<std::vector<double>(const BatchPart&)>& pass,
                             const std::function<void(const BudgetedEstimate&)>& shown = {});

} // namespace cmpg
