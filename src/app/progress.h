// One line about how far an optimisation is.
#pragma once

#include "base/stopwatch.h"

#include <cmpg/recovery.h>

#include <iosfwd>
#include <optional>
#include <string>

namespace cmpg {

// "step 12/200  loss 1.234e-03  3.4 M samples/s  ETA 1:23"
std::string progressLine(const v1::RecoveryStep& step, std::uint32_t steps, double samplesPerSecond, double secondsLeft);

// Rewrites one line on a terminal; elsewhere prints a line every few steps and at the last one, wherever the run ends.
class Progress {
  public:
    Progress(std::ostream& out, bool terminal, std::uint32_t steps);
    // `budget`: seconds left for steps, where they end by time as well.
    void update(const v1::RecoveryStep& step, std::optional<double> budget = {});
    void finish(); // leaves the last line

  private:
    std::ostream& out_;
    bool terminal_;
    std::uint32_t steps_, interval_;
    Stopwatch watch_;
    std::uint32_t done_ = 0;
    std::size_t width_ = 0; // of the line on the terminal, to blank it
    std::string left_;      // the last line, where it was not printed
    std::uint64_t samples_ = 0;
};

} // namespace cmpg
