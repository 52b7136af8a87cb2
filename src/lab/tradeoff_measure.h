// Measures settings side by side: seconds, variance and bias of their passes, over several trainings each.
#pragma once

#include "lab/compare_subject.h"
#include "lab/tradeoff_knobs.h"

namespace cmpg {

struct SettingResult {
    Setting setting;
    std::uint64_t passes = 0;
    double secondsPerPass = 0, trainSeconds = 0; // of one training
    Uncertain relativeVariance;                  // of one pass, over |reference|^2; the error is over the turns
    Bias bias;
    double squaredBias = 0; // relative; 0 where none was seen, that of the first setting where nothing tells them apart
    Uncertain gain;     // of efficiency, 1 / (variance x seconds), over that of the first setting; the error is that of its logarithm
    std::string chosen; // by auto and the gate of the roulette, in the last turn

    double errorOfPass() const { return errorAfter(secondsPerPass); }
    // Relative, of the mean of as many passes as fit.
    double errorAfter(double seconds) const;
};

struct TradeoffBudget {
    double seconds = 1;       // of passes, for each setting
    std::uint32_t turns = 3;  // each with a training of its own
    std::uint32_t passes = 8; // at least
    double referenceSeconds = 1;
};

struct TradeoffMeasurement {
    std::vector<SettingResult> results; // as the settings, the first of which is the one the others are compared with
    MeasuredReference reference;
};

// Without `given` the settings of the largest depth make the reference. Adds seconds to the report.
TradeoffMeasurement measureSettings(CompareSubject& subject, const std::vector<Setting>& settings, const TradeoffBudget& budget,
                                    std::optional<Reference> given, Report& report, const std::function<void(const std::string&)>& progress);

// Settings that no other one beats in both seconds and error of a pass, fastest first.
std::vector<std::size_t> frontier(const std::vector<SettingResult>& results);

// How much less time a setting needs than the first for the error that the first has after `seconds`: the gain where neither is biased.
// 0: never gets there.
double advantage(const SettingResult& result, const SettingResult& first, double seconds);

// One change per knob: the best of those that beat the first setting by more than their error, or lie on the frontier; best first.
std::vector<KnobChange> bestChanges(const std::vector<SettingResult>& results, double seconds, std::size_t most);

} // namespace cmpg
