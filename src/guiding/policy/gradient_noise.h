// How noisy the gradient of a step is, from derivative passes that ran in two halves.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace cmpg {

class GradientNoise {
  public:
    using Gradients = std::vector<std::vector<double>>; // by parameter

    // `half`: half of how two halves with random numbers of their own differ, whose mean was added to `sum`: the gradient of all views so far.
    void add(const Gradients& half, const Gradients& sum);
    // Squared standard error over squared length, of the parameter where that is most; none where nothing scattered.
    std::optional<double> ratio() const;

  private:
    std::vector<double> noise_, signal_; // by parameter: squared standard error, squared length
};

} // namespace cmpg
