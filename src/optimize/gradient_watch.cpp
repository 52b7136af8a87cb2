// Looks at the gradients of a run for what wastes a night.
#include "optimize/gradient_watch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

constexpr std::size_t kWindow = 64, kFewest = 16; // norms whose median is the usual one, and how many it takes
constexpr double kExplosion = 100; // times the usual norm; noise and a changed sampling stay within tens
constexpr double kDivergence = 10; // times the lowest loss
constexpr double kStall = 1e-6;    // of the largest norm so far: rates relative to it no longer reach a float's last bit
constexpr double kFound = 0.1;     // of the first loss: below, a small gradient means that the end is near
constexpr double kNoisy = 0.5;     // of the sum of squares, in the few largest of hundreds of samples or more
constexpr std::uint32_t kQuiet = 16;

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

std::vector<GradientWatch::Finding> GradientWatch::observe(const StepReport& report) {
    const double norm = recordOf(report).gradientNorm;
    if (lowestLoss_ < 0)
        firstLoss_ = lowestLoss_ = report.loss;
    lowestLoss_ = std::min(lowestLoss_, report.loss);
    largest_ = std::max(largest_, norm);

    double usual = norm;
    if (norms_.size() >= kFewest) {
        std::vector<double> sorted(norms_.begin(), norms_.end());
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        usual = sorted[sorted.size() / 2];
    }
    norms_.push_back(norm);
    if (norms_.size() > kWindow)
        norms_.pop_front();

    std::vector<Finding> findings;
    if (explode_.observe(usual > 0 && norm > kExplosion * usual, 3))
        findings.push_back({"gradients_explode", "gradients are " + times(norm / usual) + " times as large as usual: lower --rate, or let it fall with --schedule",
                            {{"norm", norm}, {"usual", usual}}});
    if (diverge_.observe(lowestLoss_ > 0 && report.loss > kDivergence * lowestLoss_, 8))
        findings.push_back({"gradients_explode", "the loss has been " + times(kDivergence) + " times its lowest for some steps: lower --rate, or let it fall with --schedule",
                            {{"loss", report.loss}, {"lowest", lowestLoss_}}});
    if (stall_.observe(norm <= kStall * largest_ && report.loss > kFound * firstLoss_ && report.loss > 0, 16))
        findings.push_back({"gradients_stall",
                            "gradients are all but zero, and the loss is not: values may be at the end of their range, or no path brings light from them to "
                            "the image. Begin elsewhere with --set, or raise --spp-gradient or --max-depth",
                            {{"norm", norm}, {"largest", largest_}, {"loss", report.loss}}});
    if (noisy_.observe(report.concentration > kNoisy, 8))
        findings.push_back({"gradients_noisy",
                            "a few samples make up most of the gradient: raise --spp-gradient, let --sampling be auto, or look for small, strong lights that "
                            "only chance finds",
                            {{"share", report.concentration}}});
    return findings;
}

} // namespace cmpg
