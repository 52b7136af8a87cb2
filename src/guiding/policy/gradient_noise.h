// How noisy the gradient of a step is, from derivative passes that ran in two halves.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace cmpg {

class GradientNoise {
  public:
    using Gradients = std::vector<std::vector<double>>; // by parameter

    // Two halves with random numbers of their own, whose mean was added to `sum`: the gradient of all views so far.
    void add(const Gradients& a, const Gradients& b, const Gradients& sum);
    // Squared standard error over squared length, of the parameter where that is most; none where nothing scattered.
    std::optional<double> ratio() const;

  private:
    std::vector<double> noise_, signal_; // by parameter: squared standard error, squared length
};

} // namespace cmpg
