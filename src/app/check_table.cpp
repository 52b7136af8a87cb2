// The table that gradient --check prints.
#include "app/check_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

const Comparison& worstOf(const CheckResult& result, std::size_t from) {
    return *std::min_element(result.comparisons.begin() + std::ptrdiff_t(from), result.comparisons.end(), [](const Comparison& a, const Comparison& b) {
        return a.probability != b.probability ? a.probability < b.probability : std::abs(a.z()) > std::abs(b.z());
    });
}

} // namespace

std::string checkTable(const CheckResult& result, const std::string& parameter, const std::string& direction) {
    char line[256];
    std::snprintf(line, sizeof line, "%s, direction %s, step %g, %u repetitions\n", parameter.c_str(), direction.c_str(), result.step,
                  result.repetitions);
    std::string text = line;
    std::snprintf(line, sizeof line, "  %-12s %13s %13s %11s %8s %10s %10s\n", "", "forward", "finite diff.", "std. error", "z",
                  "rel. error", "detects");
    text += line;
    const auto row = [&](const Comparison& c, const std::string& name) {
        std::snprintf(line, sizeof line, "  %-12s %13.6g %13.6g %11.3g %8.2f", name.c_str(), c.forward, c.finite, c.standardError, c.z());
        text += line;
        std::snprintf(line, sizeof line, " %9.3f%% %9.3f%%\n", 100 * c.relativeError(), 100 * c.power());
        text += c.vanishes() ? "          -          -\n" : line;
    };
    std::size_t means = 0;
    while (means < result.comparisons.size() && result.comparisons[means].what.rfind("block", 0) != 0)
        ++means;
    for (std::size_t i = 0; i < means; ++i)
        row(result.comparisons[i], result.comparisons[i].what);
    const Comparison& worst = worstOf(result, means);
    row(worst, worst.what);
    const double overall = worstOf(result, 0).probability;
    std::snprintf(
        line, sizeof line,
        "  %s: of %zu comparisons (channel means, blocks; the worst block is shown) the worst has probability %.2g by chance; limit %.2g\n",
        result.agrees() ? "agrees" : "DISAGREES", result.comparisons.size(), overall, result.threshold);
    text += line;
    const auto first = result.comparisons.begin(), last = first + std::ptrdiff_t(means);
    if (std::all_of(first, last, [](const Comparison& c) { return c.vanishes(); }))
        text += "  nothing to compare: the parameter has no effect on the mean of this image that shows above the errors\n";
    else if (std::any_of(first, last, [](const Comparison& c) { return !c.vanishes() && c.power() > 0.1; }))
        text += "  weak: errors below a tenth of the gradient would not show; raise --spp\n";
    return text;
}

} // namespace cmpg
