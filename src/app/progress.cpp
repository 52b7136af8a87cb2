// One line about how far an optimisation is.
#include "app/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>

namespace cmpg {
namespace {

constexpr std::uint32_t kLines = 20; // about as many where the output is not a terminal

// "7 s", "1:23", "2:05:09"
std::string duration(double seconds) {
    const long long total = std::llround(std::max(seconds, 0.0));
    char text[48];
    if (total < 60)
        std::snprintf(text, sizeof text, "%lld s", total);
    else if (total < 3600)
        std::snprintf(text, sizeof text, "%lld:%02lld", total / 60, total % 60);
    else
        std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", total / 3600, total / 60 % 60, total % 60);
    return text;
}

} // namespace

std::string progressLine(const v1::RecoveryStep& step, std::uint32_t steps, double samplesPerSecond, double secondsLeft) {
    char text[160];
    std::snprintf(text, sizeof text, "step %u/%u  loss %.4e  %.2f M samples/s  ETA ", step.step + 1, steps, step.loss,
                  samplesPerSecond * 1e-6);
    std::string line = text + duration(secondsLeft);
    if (step.dropped > 0)
        line += "  dropped " + std::to_string(step.dropped);
    return line;
}

Progress::Progress(std::ostream& out, bool terminal, std::uint32_t steps)
    : out_(out), terminal_(terminal), steps_(steps), interval_(std::max(1u, steps / kLines)) {}

void Progress::update(const v1::RecoveryStep& step, std::optional<double> budget) {
    ++done_;
    samples_ += step.paths;
    const double seconds = std::max(watch_.seconds(), 1e-9);
    const double stepsLeft = seconds / done_ * (steps_ - std::min(step.step + 1, steps_)), left = std::min(stepsLeft, budget.value_or(stepsLeft));
    std::string line = progressLine(step, steps_, double(samples_) / seconds, left);
    left_.clear();
    if (terminal_) {
        out_ << '\r' << line << std::string(width_ > line.size() ? width_ - line.size() : 0, ' ') << std::flush;
        width_ = line.size();
    } else if (done_ == 1 || step.step + 1 == steps_ || (step.step + 1) % interval_ == 0) {
        out_ << line << std::endl;
    } else {
        left_ = std::move(line);
    }
}

void Progress::finish() {
    if (terminal_ && width_ > 0)
        out_ << std::endl;
    else if (!left_.empty())
        out_ << left_ << std::endl;
    width_ = 0;
    left_.clear();
}

} // namespace cmpg
