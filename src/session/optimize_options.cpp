// The options of an optimisation as its configuration.
#include "session/optimize_options.h"

#include "base/error.h"
#include "optimize/recovery_config.h"
#include "session/option_values.h"

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

OptimizeConfig optimizeConfig(const Options& options) {
    v1::RecoveryOptions recovery = options.recovery;
    recovery.spp = options.effectiveSpp();
    recovery.sppGradient = options.effectiveSppGradient();
    recovery.seed = options.seed;
    recovery.loss = options.loss;
    recovery.rates = parseRates(options.rate);
    OptimizeConfig config = configOf(recovery);
    config.stopAfter = options.stopAfter.value_or(recovery.steps);
    return config;
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
