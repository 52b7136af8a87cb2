// Runs estimators of the same vector against each other: passes taken in turn, errors over time, a reference, figures of merit.
#include "lab/compare_runner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

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

// Sum over the passes but the first of estimates of their variance: grows from turn to turn.
double varianceSum(const EstimateStatistics& statistics) {
    return statistics.passes() < 2 ? 0 : statistics.variance().value * double(statistics.passes() - 1);
}

class Measurement {
  public:
    Measurement(const std::vector<Contestant>& contestants, const CompareBudget& budget, std::vector<GradientResult>& results,
                const std::function<void(const std::string&)>& progress)
        : contestants_(contestants), budget_(budget), results_(results), progress_(progress), due_(contestants.size(), 1) {}

    std::vector<Snapshot> run() {
        for (std::size_t next = chooseNext(); next < results_.size(); next = chooseNext())
            takeTurn(next);
        return std::move(snapshots_);
    }

  private:
    bool reached(const GradientResult& r, double share) const {
        return double(r.statistics.passes()) >= share * budget_.passes && (!budget_.seconds || r.seconds >= share * *budget_.seconds);
    }

    std::size_t chooseNext() const {
        std::size_t next = results_.size();
        const auto spent = [&](const GradientResult& r) { return budget_.seconds ? r.seconds : double(r.statistics.passes()); };
        for (std::size_t i = 0; i < results_.size(); ++i)
            if (!reached(results_[i], 1) && (next == results_.size() || spent(results_[i]) < spent(results_[next])))
                next = i;
        return next;
    }

    void takeTurn(std::size_t index) {
        GradientResult& r = results_[index];
        const Contestant& contestant = contestants_[index];
        const auto turn = std::uint32_t(r.turns.size());
        const double varianceBefore = varianceSum(r.statistics), secondsBefore = r.seconds;
        const std::uint64_t before = r.statistics.passes();
        if (contestant.begin)
            contestant.begin(turn);
        do
            takePass(index);
        while (budget_.turns > 0 && !reached(r, double(turn + 1) / budget_.turns));
        if (contestant.end)
            contestant.end();
        if (budget_.turns == 0)
            return;
        const std::uint64_t after = r.statistics.passes();
        r.turns.push_back({(varianceSum(r.statistics) - varianceBefore) / double(after - std::max<std::uint64_t>(before, 1)),
                           (r.seconds - secondsBefore) / double(after - before)});
    }

    void takePass(std::size_t index) {
        GradientResult& r = results_[index];
        const Pass pass = contestants_[index].pass(std::uint32_t(r.statistics.passes()));
        r.statistics.add(pass.values);
        r.seconds += pass.seconds;
        r.paths += pass.paths;
        const std::uint64_t passes = r.statistics.passes();
        if (passes == due_[index] || reached(r, 1)) {
            const auto& mean = r.statistics.mean();
            snapshots_.push_back({index, passes, r.seconds, std::vector<float>(mean.begin(), mean.end())});
            due_[index] = nextSnapshot(passes);
        }
        if (!progress_)
            return;
        char text[160];
        std::snprintf(text, sizeof text, "%s: %llu passes, %.1f s", r.name.c_str(), static_cast<unsigned long long>(passes), r.seconds);
        progress_(text);
    }

    const std::vector<Contestant>& contestants_;
    const CompareBudget& budget_;
    std::vector<GradientResult>& results_;
    const std::function<void(const std::string&)>& progress_;
    std::vector<Snapshot> snapshots_;
    std::vector<std::uint64_t> due_;
};

// 1 / (variance x time): comparable without a reference. 0 for what never varies: it has found nothing, and the mean of it is no reference.
double merit(const GradientResult& r) {
    const double variance = r.statistics.variance().value;
    return variance > 0 ? 1 / (variance * r.secondsPerPass()) : 0;
}

MeasuredReference makeReference(const std::vector<Contestant>& contestants, std::size_t entries, const CompareBudget& budget,
                                const std::vector<GradientResult>& results, const std::function<void(const std::string&)>& progress) {
    std::size_t best = results.size();
    double goal = std::numeric_limits<double>::infinity(), spent = 0;
    for (std::size_t i = 0; i < results.size(); ++i) {
        if (contestants[i].makesReference && (best == results.size() || merit(results[i]) > merit(results[best])))
            best = i;
        if (merit(results[i]) > 0)
            goal = std::min(goal, results[i].statistics.meanVariance());
        spent += results[i].seconds;
    }
    const double most = budget.referenceSeconds.value_or(2 * spent);
    MeasuredReference made;
    made.madeBy = contestants[best].name;
    EstimateStatistics statistics(entries);
    constexpr std::uint64_t kFewest = 4; // passes: they have to show their own variance
    if (contestants[best].begin)
        contestants[best].begin(kReferenceTurn);
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
    if (contestants[best].end)
        contestants[best].end();
    made.passes = statistics.passes();
    made.reference = referenceOf(statistics);
    return made;
}

// Relative errors of independent factors add in squares. Of 0 there is none.
Uncertain inverse(Uncertain a, double factor) {
    const double value = a.value > 0 ? 1 / (a.value * factor) : std::numeric_limits<double>::quiet_NaN();
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
    const std::vector<Snapshot> snapshots = Measurement(contestants, budget, comparison.results, progress).run();
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
