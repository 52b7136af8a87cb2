// The options as the library has them.
#pragma once

#include "session/options.h"

#include <cmpg/recovery.h>

namespace cmpg {

// Whether the command draws from a guide or learns one.
bool usesGuide(const Options& options);

// `depth`: of the paths, for the scene.
v1::PathOptions pathOptions(const Options& options, std::uint32_t depth);

// Without --param. Error(Usage) on rates that mean nothing.
v1::RecoveryOptions recoveryOptions(const Options& options, std::uint32_t depth);

// What --checkpoint-every says: after so many steps, or so much time; both 0: never. Error(Usage) on what is neither.
struct CheckpointInterval {
    std::uint32_t steps = 0;
    double seconds = 0;
};
CheckpointInterval checkpointInterval(const Options& options);

} // namespace cmpg
