// What an optimisation is, by name: two runs whose entries agree have the same results.
#pragma once

#include "optimize/checkpoint.h"
#include "render/renderer.h"
#include "session/options.h"

namespace cmpg {

// Of the scene as it is before the first step, and before a renderer was made of it. `options` with the depth that will be used.
Checkpoint::Identity runIdentity(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& parameters,
                                 const std::vector<View>& views, const std::vector<Target>& targets);

// Error(Usage or Input) that names the first difference.
void requireSameRun(const Checkpoint& checkpoint, const Checkpoint::Identity& run, const std::string& folder);

} // namespace cmpg
