// The checkpoint that a recovery continues from.
#pragma once

#include "optimize/checkpoint.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cmpg::v1 {

// None where the folder has none; `refused` says why others were passed over. Error(Input) where there are some, and none can be read.
std::optional<Checkpoint> checkpointIn(const std::filesystem::path& folder, std::vector<std::string>& refused);

} // namespace cmpg::v1
