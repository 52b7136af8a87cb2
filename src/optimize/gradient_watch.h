// Looks at the gradients of a run for what wastes a night: they explode, stall, or are the work of a few samples.
#pragma once

#include "optimize/optimize.h"

#include <cmpg/recovery.h>

#include <deque>
#include <optional>

namespace cmpg {

class GradientWatch {
  public:
    // What has become true with this step: "gradients_explode", "gradients_stall", "gradients_noisy". Each is found once, and again only after it was not
    // so for some time.
    std::vector<v1::Warning> observe(const StepReport& report);

  private:
    // A condition that has to hold, or not to hold, for some steps in a row.
    struct Alarm {
        std::uint32_t holds = 0, quiet = 0;
        bool raised = false;
        bool observe(bool condition, std::uint32_t steps); // whether it is raised now
    };
    std::deque<double> norms_, losses_, lossErrors_; // of the last steps
    double largest_ = 0, largestLoss_ = 0; // losses: medians of some steps
    std::optional<double> lowestLoss_;     // also below 0, where nothing but noise is left
    Alarm explode_, diverge_, stall_, noisy_;
};

} // namespace cmpg
