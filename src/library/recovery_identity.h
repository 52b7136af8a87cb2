// What a recovery is, by name: those whose entries agree have the same results.
#pragma once

#include "optimize/checkpoint.h"

#include <cmpg/recovery.h>

namespace cmpg::v1 {

// Of the options; `config` and `maxDepth` are what they were made into, `parameters` the names of what is recovered.
Checkpoint::Identity identityOf(const RecoveryOptions& options, const OptimizeConfig& config, std::uint32_t maxDepth, const std::string& parameters);

// Error(Usage or Input) that names the first difference between a checkpoint in `folder` and a recovery.
void requireSame(const Checkpoint::Identity& saved, const Checkpoint::Identity& own, const std::filesystem::path& folder);

} // namespace cmpg::v1
