// Runs estimators of the same vector against each other: passes taken in turn, errors over time, a reference, figures of merit.
#include "app/compare_runner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

constexpr std::uint32_t kReferenceIndex = 1u << 30; // first pass of the reference: numbers that no measured pass used
constexpr double kReferenceGoal = 0.1;              // its squared error, as a share of the best contestant's

// The mean after some passes; its error is known once there is a reference.
struct Snapshot {
    std::size_t contestant;
    std::uint64_t passes;
    double seconds;
    std::vector<float> mean;
};

// About six points per factor of ten.
std::uint64_t nextSnapshot(std::uint64_t passes) { return std::max(passes + 1, std::uint64_t(std::ceil(double(passes) * 1.45))); }

std::vector<Snapshot> measure(const std::vector<Contestant>& contestants, const CompareBudget& budget, std::vector<GradientResult>& results,
                              const std::function<void(const std::string&)>& progress) {
    std::vector<Snapshot> snapshots;
    std::vector<std::uint64_t> due(contestants.size(), 1);
    const auto done = [&](const GradientResult& r) {
        return r.statistics.passes() >= budget.passes && (!budget.seconds || r.seconds >= *budget.seconds);
    };
    for (;;) {
        std::size_t next = contestants.size();
        for (std::size_t i = 0; i < results.size(); ++i) {
            if (done(results[i]))
                continue;
            const auto spent = [&](const GradientResult& r) { return budget.seconds ? r.seconds : double(r.statistics.passes()); };
            if (next == contestants.size() || spent(results[i]) < spent(results[next]))
                next = i;
        }
        if (next == contestants.size())
            break;
        GradientResult& result = results[next];
        const Pass pass = contestants[next].pass(std::uint32_t(result.statistics.passes()));
        result.statistics.add(pass.values);
        result.seconds += pass.seconds;
        result.paths += pass.paths;
        const std::uint64_t passes = result.statistics.passes();
        if (passes == due[next] || done(result)) {
            const auto& mean = result.statistics.mean();
            snapshots.push_back({next, passes, result.seconds, std::vector<float>(mean.begin(), mean.end())});
            due[next] = nextSnapshot(passes);
        }
        if (progress) {
            char text[160];
            std::snprintf(text, sizeof text, "%s: %llu passes, %.1f s", result.name.c_str(), static_cast<unsigned long long>(passes),
                          result.seconds);
            progress(text);
        }
    }
    return snapshots;
}

// 1 / (variance x time): comparable without a reference.
double merit(const GradientResult& r) { return 1 / (r.statistics.variance().value * r.secondsPerPass()); }

MeasuredReference makeReference(const std::vector<Contestant>& contestants, std::size_t entries, const CompareBudget& budget,
                                const std::vector<GradientResult>& results, const std::function<void(const std::string&)>& progress) {
    std::size_t best = 0;
    double goal = results.front().statistics.meanVariance(), spent = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        if (!(merit(results[best]) >= merit(results[i])))
            best = i;
        goal = std::min(goal, results[i].statistics.meanVariance());
        spent += results[i].seconds;
    }
    const double most = budget.referenceSeconds.value_or(2 * spent);
    MeasuredReference made;
    made.madeBy = contestants[best].name;
    EstimateStatistics statistics(entries);
    constexpr std::uint64_t kFewest = 4; // passes: they have to show their own variance
    while (statistics.passes() < kFewest ||
           (made.seconds < most && statistics.meanVariance() > kReferenceGoal * goal)) {
        const Pass pass = contestants[best].pass(kReferenceIndex + std::uint32_t(statistics.passes()));
        statistics.add(pass.values);
        made.seconds += pass.seconds;
        if (progress) {
            char text[160];
            std::snprintf(text, sizeof text, "reference by %s: %.1f of at most %.1f s", made.madeBy.c_str(), made.seconds,
                          most);
            progress(text);
        }
    }
    made.passes = statistics.passes();
    made.reference = referenceOf(statistics);
    return made;
}

// Relative errors of independent factors add in squares.
Uncertain inverse(Uncertain a, double factor) {
    const double value = 1 / (a.value * factor);
    return {value, value * a.error / a.value};
}

Uncertain quotient(const Uncertain& a, const Uncertain& b) {
    const double value = a.value / b.value;
    return {value, value * std::hypot(a.error / a.value, b.error / b.value)};
}

} // namespace

GradientComparison compareGradients(const std::vector<Contestant>& contestants, std::size_t entries, const CompareBudget& budget,
                                    std::optional<Reference> given, const std::function<void(const std::string&)>& progress) {
    GradientComparison comparison;
    for (const Contestant& contestant : contestants)
        comparison.results.emplace_back(contestant.name, entries);
    const std::vector<Snapshot> snapshots = measure(contestants, budget, comparison.results, progress);
    if (given)
        comparison.reference.reference = std::move(*given);
    else
        comparison.reference = makeReference(contestants, entries, budget, comparison.results, progress);
    std::vector<double> mean(entries);
    for (const Snapshot& s : snapshots) {
        std::copy(s.mean.begin(), s.mean.end(), mean.begin());
        comparison.results[s.contestant].curve.push_back(
            {s.seconds, s.passes, meanSquaredError(mean, comparison.reference.reference)});
    }
    assess(comparison);
    return comparison;
}

void assess(GradientComparison& comparison) {
    const Reference& reference = comparison.reference.reference;
    const double norm = reference.squaredNorm();
    for (GradientResult& r : comparison.results) {
        r.mse = meanSquaredError(r.statistics.mean(), reference);
        const Uncertain variance = r.statistics.variance();
        r.relativeVariance = {variance.value / norm, variance.error / norm};
        r.bias = biasOf(r.statistics, reference);
        r.efficiency = inverse(r.relativeVariance, r.secondsPerPass());
        const GradientResult& first = comparison.results.front();
        r.ratio = &r == &first ? Uncertain{1, 0} : quotient(r.efficiency, first.efficiency);
    }
}

} // namespace cmpg
