// Looks at the gradients of a run for what wastes a night: they explode, stall, or are the work of a few samples.
#pragma once

#include "optimize/optimize.h"

#include <deque>

namespace cmpg {

class GradientWatch {
  public:
    struct Finding {
        std::string event; // "gradients_explode", "gradients_stall", "gradients_noisy"
        std::string text;  // with the remedy
        std::vector<std::pair<std::string, double>> numbers;
        std::vector<std::string> options; // that the remedy is about: see Error
    };
    // What has become true with this step. Each is found once, and again only after it was not so for some time.
    std::vector<Finding> observe(const StepReport& report);

  private:
    // A condition that has to hold, or not to hold, for some steps in a row.
    struct Alarm {
        std::uint32_t holds = 0, quiet = 0;
        bool raised = false;
        bool observe(bool condition, std::uint32_t steps); // whether it is raised now
    };
    std::deque<double> norms_, losses_; // of the last steps
    double largest_ = 0, lowestLoss_ = -1, firstLoss_ = -1; // losses: medians of some steps
    Alarm explode_, diverge_, stall_, noisy_;
};

} // namespace cmpg
