// What ranks that share a run have to agree on.
#pragma once

#include "session/options.h"
#include "vk/device.h"

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace cmpg {

// For Device::Options::select: where a machine has several graphics processors and several ranks, one after the other by local rank; else the best.
std::string deviceOfRank();
// Error(Device) on all ranks if not all have the same device, driver and options: their results would differ.
void requireSameRanks(const Device& device, const Options& options);

struct StepAgreement {
    bool timeUp = false, stop = false;
};
// After a step: whether the first rank's time is up, and whether any was told to stop. Error(Numerical) on all if they have not computed the same loss.
StepAgreement agreeAfterStep(double loss, bool timeUp, bool stop);

// What ranks sent, for the report.
nlohmann::ordered_json trafficReport();

} // namespace cmpg
