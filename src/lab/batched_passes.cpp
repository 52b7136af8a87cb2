// Passes of a command in batches, as --batches, --error-target and --time-budget want them.
#include "lab/batched_passes.h"

#include "base/log.h"

#include <algorithm>
#include <cstdio>

namespace cmpg {

SampleBudget sampleBudget(const Options& options, const Report& report, std::uint32_t spp) {
    SampleBudget budget;
    budget.batches = options.effectiveBatches();
    budget.samples = spp / budget.batches;
    if (options.errorTarget)
        budget.error = double(*options.errorTarget);
    if (options.timeBudget) {
        budget.seconds = double(*options.timeBudget);
        budget.clock = [&report] { return report.elapsed(); };
    }
    return budget;
}

PassKey partKey(const PassKey& key, const BatchPart& part, std::uint32_t batches, bool continues) {
    constexpr std::uint32_t kPasses = 16; // that one batch may have of its own, see PassKey::pass
    PassKey own = key;
    own.pass += kPasses * (1 + part.batch + (continues ? 0 : batches * part.stage));
    own.firstSample = continues ? part.firstSample : 0;
    return own;
}

Image toImage(const std::vector<double>& values, int width, int height) {
    Image image(width, height, 3);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(values[i]);
    return image;
}

std::vector<double> fromImage(const Image& image) { return {image.values.begin(), image.values.end()}; }

std::vector<double> joined(const std::vector<std::vector<double>>& gradients) {
    std::vector<double> values;
    for (const auto& gradient : gradients)
        values.insert(values.end(), gradient.begin(), gradient.end());
    return values;
}

void divide(std::span<const double> values, std::vector<std::vector<double>>& gradients) {
    for (auto& gradient : gradients) {
        std::copy_n(values.begin(), gradient.size(), gradient.begin());
        values = values.subspan(gradient.size());
    }
}

ExitStatus conclude(const BudgetedEstimate& estimate, const Options& options, Report& report, Session& session,
                  std::optional<std::uint32_t> Options::* samples) {
    const std::uint32_t batches = options.effectiveBatches(), spp = estimate.samples * batches;
    const EstimateError& error = estimate.error;
    const bool reached = !options.errorTarget || error.relative <= double(*options.errorTarget);
    report.spp = spp;
    report.extra["error"] = {{"relative", error.relative}, {"low", error.low}, {"high", error.high}, {"degrees", error.degrees},
                             {"batches", batches},         {"spp", spp},       {"reached", reached}};
    session.record([&](Options& o) {
        o.*samples = spp;
        o.batches = batches;
        o.timeBudget.reset();
    });
    if (!options.quiet)
        textOut(options) << "  error             " << describe(error) << ", " << spp << " samples per pixel in " << batches << " batches\n";
    if (reached)
        return ExitStatus::Done;
    char target[32];
    std::snprintf(target, sizeof target, "%.3g %%", 100 * double(*options.errorTarget));
    const bool time = estimate.end == BudgetedEstimate::End::Time;
    logWarn("the error target of " + std::string(target) + " was not reached: the error is " + describe(error) + " after " + std::to_string(spp) +
            " samples per pixel; " + (time ? "allow more --time-budget" : "allow more samples"));
    return ExitStatus::CheckFailed;
}

} // namespace cmpg
