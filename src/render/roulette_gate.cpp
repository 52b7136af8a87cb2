// The gate of the roulette.
#include "render/roulette_gate.h"

#include "guiding/policy/pass_differences.h"
#include "render/pass_halves.h"

namespace cmpg {
namespace {

constexpr std::uint32_t kGatePasses = 2; // with roulette, and as many without

} // namespace

std::optional<RouletteGain> measureRoulette(
    const std::function<PassResult(std::uint32_t pass, bool roulette, std::vector<std::vector<double>>& gradients)>& run) {
    PassResult measured[2];
    PassDifferences differences[2];
    for (std::uint32_t pass = 0; pass < kGatePasses; ++pass)
        for (const bool roulette : {false, true}) {
            std::vector<std::vector<double>> gradients;
            measured[roulette].add(run(pass, roulette, gradients));
            differences[roulette].add(entries(gradients));
        }
    if (!(measured[0].variance > 0) || measured[0].rays == 0)
        return {};
    return RouletteGain{worseVarianceRatio(measured[1].variance / measured[0].variance, differences[1], differences[0]),
                        double(measured[1].rays) / double(measured[0].rays)};
}

} // namespace cmpg
