// What ranks that share a run have to agree on.
#pragma once

#include "session/options.h"

#include <nlohmann/json_fwd.hpp>

namespace cmpg {

// Error(Usage) on all ranks if not all have the same options: their results would differ.
void requireSameOptions(const Options& options);

struct StepAgreement {
    bool timeUp = false, stop = false;
};
// After a step: whether the first rank's time is up, and whether any was told to stop.
StepAgreement agreeAfterStep(bool timeUp, bool stop);

// The first rank's, of a number that each measured.
std::uint32_t ofFirstRank(std::uint32_t value);

// What ranks sent, for the report.
nlohmann::ordered_json trafficReport();

} // namespace cmpg
