// The options as the library has them.
#include "session/library_options.h"

#include "base/error.h"
#include "session/option_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace cmpg {
namespace {

// "RATE" for all slots, "SLOT=RATE" for one.
std::vector<std::pair<std::string, float>> parseRates(const std::vector<std::string>& texts) {
    std::vector<std::pair<std::string, float>> rates;
    for (const std::string& text : texts) {
        const std::size_t equals = text.find('=');
        const std::string slot = equals == std::string::npos ? "" : text.substr(0, equals);
        const std::string value = equals == std::string::npos ? text : text.substr(equals + 1);
        char* end = nullptr;
        const float rate = std::strtof(value.c_str(), &end);
        if (value.empty() || *end != 0 || !(rate >= 0 && rate < 1e6f))
            throw Error(ErrorKind::Usage, "--rate takes RATE or SLOT=RATE with a rate from 0 to 1e6, not '" + text + "'");
        rates.emplace_back(slot, rate);
    }
    return rates;
}

} // namespace

bool usesGuide(const Options& options) {
    const bool wanted = options.sampling != Sampling::Bsdf || (options.roulette && options.isReverse()) || !options.saveGuide.empty();
    return wanted && (options.command == Command::Optimize || options.effectiveTrain() > 0 || !options.loadGuide.empty());
}

v1::PathOptions pathOptions(const Options& o, std::uint32_t depth) {
    return {.maxDepth = depth,
            .sampling = o.sampling,
            .pixelSampling = o.pixelSampling.value_or(PixelSampling::Adjoint),
            .roulette = o.roulette,
            .positivize = o.positivize,
            .lightSampling = !o.noLightSampling,
            .memory = o.memory,
            .guideMemory = o.guideMemory,
            .sampler = o.sampler,
            .guide = {.load = o.loadGuide,
                      .keep = !o.saveGuide.empty(),
                      .share = o.guideShare,
                      .rouletteEffort = o.rouletteEffort,
                      .cellRecords = o.cellRecords,
                      .directionShare = o.directionShare,
                      .forgetting = o.forgetting},
            .allFeatures = o.allFeatures};
}

v1::RecoveryOptions recoveryOptions(const Options& options, std::uint32_t depth) {
    v1::RecoveryOptions recovery = options.recovery;
    recovery.paths = pathOptions(options, depth);
    recovery.spp = options.effectiveSpp();
    recovery.sppGradient = options.effectiveSppGradient();
    recovery.seed = options.seed;
    recovery.loss = options.loss;
    recovery.rates = parseRates(options.rate);
    if (options.freeze)
        recovery.freeze = std::max(1u, *options.freeze); // the guide of no step is of no use
    if (options.errorTarget) {
        recovery.errorTarget = double(*options.errorTarget);
        recovery.batches = options.effectiveBatches();
    }
    return recovery;
}

CheckpointInterval checkpointInterval(const Options& options) {
    const std::string& text = options.checkpointEvery;
    double number = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const std::string unit(rest, text.data() + text.size());
    const std::optional<double> seconds = unit.empty() ? std::nullopt : parseSeconds(text);
    if (seconds && *seconds > 0 && number <= 1e9)
        return {.steps = 0, .seconds = *seconds};
    if (error == std::errc() && unit.empty() && number >= 0 && number <= 1e9 && number == std::floor(number))
        return {.steps = std::uint32_t(number), .seconds = 0};
    throw Error(ErrorKind::Usage, "--checkpoint-every takes a number of steps, or a time such as 30s, 10m or 1h, not '" + text + "'");
}

} // namespace cmpg
