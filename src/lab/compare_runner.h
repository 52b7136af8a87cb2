// Runs estimators of the same vector against each other: passes taken in turn, errors over time, a reference, figures of merit.
#pragma once

#include "lab/estimate_statistics.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace cmpg {

struct Pass {
    std::vector<double> values;
    double seconds = 0;
    std::uint64_t paths = 0; // camera paths
};

struct Contestant {
    std::string name;
    std::function<Pass(std::uint32_t index)> pass; // different indices: independent random numbers
    // Around each of its turns, so that what a contestant needs and learns lasts for one. The reference's is kReferenceTurn.
    std::function<void(std::uint32_t turn)> begin{};
    std::function<void()> end{};
    bool makesReference = true; // may
};
constexpr std::uint32_t kReferenceTurn = 1u << 20;

struct CompareBudget {
    std::optional<double> seconds; // of passes, for each contestant; without: `passes` each
    std::uint32_t passes = 16;     // with `seconds`: the fewest
    std::uint32_t turns = 0;       // of each contestant, equally long; 0: a pass is a turn
    std::optional<double> referenceSeconds; // most time for the reference; without: twice that of all measured passes
};

struct CurvePoint {
    double seconds = 0;
    std::uint64_t passes = 0; // or steps
    double error = 0;         // mean squared error over the entries
};

// Of CompareBudget::turns, passes by themselves.
struct Turn {
    double variance = 0; // of a pass
    double secondsPerPass = 0;
};

// How one estimator did.
struct GradientResult {
    GradientResult(std::string n, std::size_t entries) : name(std::move(n)), statistics(entries) {}

    std::string name;
    EstimateStatistics statistics;
    std::uint64_t paths = 0;
    double seconds = 0; // of all passes
    std::vector<CurvePoint> curve;
    std::vector<Turn> turns;

    // Filled by assess().
    double mse = 0;             // of the mean of all passes
    Uncertain relativeVariance; // of one pass: summed over the entries, over |reference|^2
    Bias bias;
    Uncertain efficiency; // 1 / (relative variance x seconds of one pass); NaN where passes do not vary
    Uncertain ratio;      // of efficiencies, to the first

    double secondsPerPass() const { return seconds / double(statistics.passes()); }
};

struct MeasuredReference {
    Reference reference;
    std::string madeBy; // name of the contestant; empty: given
    std::uint64_t passes = 0;
    double seconds = 0;
};

struct GradientComparison {
    std::vector<GradientResult> results; // as the contestants
    MeasuredReference reference;
};

// Whoever spent least so far goes next, so that a drift of the machine hits all alike. Without `given`, passes of the most efficient
// contestant whose passes vary, with numbers of their own, make the reference, until its squared error is a tenth of the best contestant's or the time
// is up. `progress`: called now and then with what is being done.
GradientComparison compareGradients(const std::vector<Contestant>& contestants, std::size_t entries, const CompareBudget& budget,
                                    std::optional<Reference> given, const std::function<void(const std::string&)>& progress = {});

// Figures of merit of results whose statistics and seconds are there.
void assess(GradientComparison& comparison);

} // namespace cmpg
