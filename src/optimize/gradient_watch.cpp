// Looks at the gradients of a run for what wastes a night.
#include "optimize/gradient_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

namespace cmpg {
namespace {

constexpr std::size_t kWindow = 64, kFewest = 16; // steps whose median norm is the usual one, and how many it takes; losses: kFewest
constexpr double kExplosion = 100; // times the usual norm; noise and a changed sampling stay within tens
constexpr double kDivergence = 10; // times the lowest loss, both medians: the loss of a noisy image is as noisy
constexpr double kErrors = 4;      // standard errors that such a difference has, at least: a loss without bias is near 0, and below it, at the end of a good run
constexpr double kStall = 1e-6;    // of the largest norm so far: rates relative to it no longer reach a float's last bit
constexpr double kFound = 0.1;     // of the largest loss: below, a small gradient means that the end is near
constexpr double kNoisy = 0.5;     // of the sum of squares, in the few largest of hundreds of samples or more
constexpr std::uint32_t kQuiet = 16;

double median(const std::deque<double>& values) {
    std::vector<double> sorted(values.begin(), values.end());
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
    return sorted[sorted.size() / 2];
}

void keep(std::deque<double>& values, double value, std::size_t most) {
    values.push_back(value);
    if (values.size() > most)
        values.pop_front();
}

std::string times(double factor) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", factor);
    return text;
}

} // namespace

bool GradientWatch::Alarm::observe(bool condition, std::uint32_t steps) {
    holds = condition ? holds + 1 : 0;
    quiet = condition ? 0 : quiet + 1;
    if (quiet >= kQuiet)
        raised = false;
    if (raised || holds < steps)
        return false;
    return raised = true;
}

std::vector<v1::Warning> GradientWatch::observe(const StepReport& report) {
    const double norm = recordOf(report).gradientNorm;
    const double usual = norms_.size() >= kFewest ? median(norms_) : norm;
    keep(norms_, norm, kWindow);
    largest_ = std::max(largest_, norm);
    keep(losses_, report.loss, kFewest);
    keep(lossErrors_, report.lossError, kFewest);
    const double loss = median(losses_), lossError = median(lossErrors_);
    largestLoss_ = std::max(largestLoss_, loss); // from the first step on: a good run has left it far behind before there are as many as kFewest
    if (losses_.size() == kFewest)
        lowestLoss_ = std::min(lowestLoss_.value_or(loss), loss);
    const double lowest = lowestLoss_.value_or(loss);

    std::vector<v1::Warning> findings;
    if (explode_.observe(usual > 0 && norm > kExplosion * usual, 3))
        findings.push_back({"gradients_explode", "gradients are " + times(norm / usual) + " times as large as usual: lower the rate, or let it fall",
                            {"rate", "schedule"}, {{"norm", norm}, {"usual", usual}}});
    if (diverge_.observe(loss > kDivergence * std::max(lowest, 0.0) && loss - lowest > kErrors * lossError, 8))
        findings.push_back({"gradients_explode", "the loss has been " + times(kDivergence) + " times its lowest for some steps: lower the rate, or let it fall",
                            {"rate", "schedule"}, {{"loss", loss}, {"lowest", lowest}}});
    if (stall_.observe(norm <= kStall * largest_ && loss > kFound * largestLoss_ && loss > kErrors * lossError, 16))
        findings.push_back({"gradients_stall",
                            "gradients are all but zero, and the loss is not: values may be at the end of their range, or no path brings light from them to "
                            "the image. Begin elsewhere, or raise the samples of derivative passes or the depth",
                            {"set", "spp-gradient", "max-depth"}, {{"norm", norm}, {"largest", largest_}, {"loss", loss}}});
    if (report.concentration > 0 && noisy_.observe(report.concentration > kNoisy, 16)) // 0: not measured
        findings.push_back({"gradients_noisy",
                            "a few samples make up most of the gradient: take more of them, let the sampling be chosen automatically, or look for "
                            "small, strong lights that only chance finds",
                            {"spp-gradient", "sampling"}, {{"share", report.concentration}}});
    return findings;
}

} // namespace cmpg
