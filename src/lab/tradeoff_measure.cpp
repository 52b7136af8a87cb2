// Measures settings side by side: seconds, variance and bias of their passes, over several trainings each.
#include "lab/tradeoff_measure.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

namespace cmpg {
namespace {

// What a contestant has while it is its turn: renderers are large.
struct Stage {
    std::unique_ptr<MethodRenderer> renderer;
    double trainSeconds = 0;
    std::uint32_t trainings = 0;
    std::string chosen;
};

// Mean of the logarithms of this setting's efficiency over the first one's, turn by turn; they meet the same state of the machine.
Uncertain gainOf(const GradientResult& result, const GradientResult& first) {
    if (&result == &first)
        return {1, 0};
    const std::size_t n = std::min(result.turns.size(), first.turns.size());
    std::vector<double> logs;
    for (std::size_t t = 0; t < n; ++t)
        logs.push_back(std::log(first.turns[t].variance * first.turns[t].secondsPerPass / (result.turns[t].variance * result.turns[t].secondsPerPass)));
    const double mean = std::accumulate(logs.begin(), logs.end(), 0.0) / double(n);
    double spread = 0;
    for (const double l : logs)
        spread += (l - mean) * (l - mean);
    // Few turns may agree by chance; the passes' own spread is a lower bound.
    const Uncertain own = result.statistics.variance(), other = first.statistics.variance();
    const double passes = std::hypot(own.error / own.value, other.error / other.value);
    const double turns = n > 1 ? std::sqrt(spread / double(n * (n - 1))) : 0;
    return {std::exp(mean), std::max(passes, turns)};
}

SettingResult summarise(const Setting& setting, const GradientResult& result, const GradientResult& first, const Stage& stage) {
    SettingResult r{setting, result.statistics.passes(), result.secondsPerPass(), 0, result.relativeVariance, result.bias, 0, gainOf(result, first), stage.chosen};
    r.trainSeconds = stage.trainSeconds / std::max(1u, stage.trainings);
    const double n = double(result.turns.size());
    double mean = 0, spread = 0;
    for (const Turn& t : result.turns)
        mean += t.variance / n;
    for (const Turn& t : result.turns)
        spread += (t.variance - mean) * (t.variance - mean);
    if (n > 1 && mean > 0)
        r.relativeVariance.error = std::max(r.relativeVariance.error, r.relativeVariance.value / mean * std::sqrt(spread / (n * (n - 1))));
    return r;
}

double ownBias(const Bias& bias) {
    return bias.verdict == Bias::Verdict::Biased ? std::max({0.0, bias.squared, bias.along * bias.along}) : 0;
}

// Most settings change nothing but the noise: what their biases seem to differ by is noise too.
bool sameBias(const Bias& a, const Bias& b) {
    constexpr double kFar = 2; // of the joint 95 % interval
    return std::abs(a.along - b.along) <= kFar * std::hypot(a.interval, b.interval);
}

} // namespace

double SettingResult::errorAfter(double seconds) const { return std::sqrt(relativeVariance.value * secondsPerPass / seconds + squaredBias); }

TradeoffMeasurement measureSettings(CompareSubject& subject, const std::vector<Setting>& settings, const TradeoffBudget& budget,
                                    std::optional<Reference> given, Report& report, const std::function<void(const std::string&)>& progress) {
    const CompareMode mode = subject.modes.front();
    std::vector<Stage> stages(settings.size());
    std::vector<Contestant> contestants;
    const auto depthOf = [&](const Setting& s) { return s.options.effectiveDepth(subject.session.host().maxDepth); };
    std::uint32_t deepest = 0;
    for (const Setting& s : settings)
        deepest = std::max(deepest, depthOf(s));
    for (std::size_t i = 0; i < settings.size(); ++i) {
        Stage& stage = stages[i];
        const CompareMethod method{settings[i].name(), settings[i].options};
        Contestant contestant;
        contestant.name = method.name;
        contestant.makesReference = depthOf(settings[i]) == deepest;
        contestant.begin = [&subject, &stage, method, mode](std::uint32_t turn) {
            stage.renderer = std::make_unique<MethodRenderer>(subject, method);
            stage.renderer->train(mode, turn);
        };
        contestant.pass = [&stage, mode](std::uint32_t index) { return stage.renderer->pass(mode, index); };
        contestant.end = [&stage, method] {
            stage.trainSeconds += stage.renderer->trainSeconds();
            ++stage.trainings;
            stage.chosen = describeDecision(method, stage.renderer->last());
            stage.renderer.reset();
        };
        contestants.push_back(std::move(contestant));
    }
    const CompareBudget compare{.seconds = budget.seconds, .passes = budget.passes, .turns = budget.turns, .referenceSeconds = budget.referenceSeconds};
    const std::size_t entries = mode == CompareMode::Forward ? std::size_t(3) * subject.view.width * subject.view.height : subject.parameterEntries();
    GradientComparison comparison = compareGradients(contestants, entries, compare, std::move(given), progress);
    TradeoffMeasurement measurement;
    for (std::size_t i = 0; i < settings.size(); ++i) {
        SettingResult& r = measurement.results.emplace_back(summarise(settings[i], comparison.results[i], comparison.results.front(), stages[i]));
        const bool alike = depthOf(settings[i]) == depthOf(settings.front()) && sameBias(r.bias, measurement.results.front().bias);
        r.squaredBias = ownBias(alike ? measurement.results.front().bias : r.bias);
        report.seconds.gradient += comparison.results[i].seconds;
    }
    report.seconds.gradient += comparison.reference.seconds;
    measurement.reference = std::move(comparison.reference);
    return measurement;
}

std::vector<std::size_t> frontier(const std::vector<SettingResult>& results) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < results.size(); ++i)
        if (std::isfinite(results[i].errorOfPass()))
            order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(results[a].secondsPerPass, results[a].errorOfPass()) < std::pair(results[b].secondsPerPass, results[b].errorOfPass());
    });
    std::vector<std::size_t> best;
    for (const std::size_t i : order)
        if (best.empty() || results[i].errorOfPass() < results[best.back()].errorOfPass())
            best.push_back(i);
    return best;
}

double advantage(const SettingResult& result, const SettingResult& first, double seconds) {
    const double goal = std::pow(first.errorAfter(seconds), 2) - result.squaredBias;
    return goal > 0 ? seconds * goal / (result.relativeVariance.value * result.secondsPerPass) : 0;
}

std::vector<KnobChange> bestChanges(const std::vector<SettingResult>& results, double seconds, std::size_t most) {
    const std::vector<std::size_t> edge = frontier(results);
    std::vector<std::pair<double, KnobChange>> found; // best of each knob
    for (std::size_t i = 1; i < results.size(); ++i) {
        const SettingResult& r = results[i];
        if (r.setting.changes.size() != 1 || r.setting.changes.front().option == "quality") // which sets other knobs
            continue;
        const double gain = advantage(r, results.front(), seconds);
        const bool better = gain > std::exp(r.gain.error), onEdge = std::find(edge.begin(), edge.end(), i) != edge.end();
        if (!(better || onEdge) || !(gain > 0))
            continue;
        const KnobChange& change = r.setting.changes.front();
        const auto known = std::find_if(found.begin(), found.end(), [&](const auto& f) { return f.second.option == change.option; });
        if (known == found.end())
            found.emplace_back(gain, change);
        else if (gain > known->first)
            *known = {gain, change};
    }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<KnobChange> changes;
    for (std::size_t i = 0; i < std::min(most, found.size()); ++i)
        changes.push_back(found[i].second);
    return changes;
}

} // namespace cmpg
