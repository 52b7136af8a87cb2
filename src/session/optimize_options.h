// The options of an optimisation as its configuration.
#pragma once

#include "optimize/optimize.h"
#include "session/options.h"

namespace cmpg {

// Without targets. Error(Usage) on rates that mean nothing.
OptimizeConfig optimizeConfig(const Options& options);

// What --checkpoint-every says: after so many steps, or so much time; both 0: never. Error(Usage) on what is neither.
struct CheckpointInterval {
    std::uint32_t steps = 0;
    double seconds = 0;
};
CheckpointInterval checkpointInterval(const Options& options);

} // namespace cmpg
