// The gate of the roulette: what it does to variance and rays of a derivative pass, measured before it is used.
#pragma once

#include "render/pass_plan.h"

#include <functional>
#include <optional>
#include <vector>

namespace cmpg {

// With roulette, over that without.
struct RouletteGain {
    double variance = 1, rays = 1;
};

// Runs passes with and without roulette, in turn. `run` adds the gradients of pass number `pass` to what it is given,
// and measures PassResult::variance. None where nothing scattered.
std::optional<RouletteGain> measureRoulette(
    const std::function<PassResult(std::uint32_t pass, bool roulette, std::vector<std::vector<double>>& gradients)>& run);

} // namespace cmpg
