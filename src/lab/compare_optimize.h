// Whole optimisations of the same parameters by different methods, side by side in time.
#pragma once

#include "lab/compare_subject.h"

namespace cmpg {

// How one method's optimisations went, all repetitions together.
struct OptimizeResult {
    CompareMethod method;
    std::uint32_t repetitions = 0;
    double steps = 0;                            // mean over the repetitions
    double seconds = 0, trainSeconds = 0;        // of a repetition; everything counts, of it learning
    Uncertain parameterError, imageError;        // mean squared, at the end; standard error over repetitions, NaN for a single one
    Uncertain ratio;                             // parameter error of the first method over this one's
    std::vector<double> secondsToFirst;          // to reach the first method's final error of the same repetition, of those that did
    std::vector<CurvePoint> curve;               // of the first repetition: parameter error after every step
    std::vector<std::vector<float>> values;      // found by the first repetition, per parameter
    std::string chosen;
};

struct OptimizeComparison {
    double initialError = 0; // of the parameters
    std::uint32_t steps = 0; // of each method, unless --time decides
    std::vector<OptimizeResult> results;
    std::vector<std::vector<float>> initial; // values at the start
    v1::RecoveryOptions options;             // of all methods, but for how they draw paths
};

// Each method goes --steps steps, or to --stop-after, or as many as --time allows, whoever spent least next.
OptimizeComparison compareOptimisations(CompareSubject& subject, const std::function<void(const std::string&)>& progress);

double meanSquaredParameterError(const std::vector<std::vector<float>>& values, const std::vector<std::vector<float>>& truth);
// When a curve first gets as low as `error`; nothing if it never does.
std::optional<double> secondsToReach(const std::vector<CurvePoint>& curve, double error);

} // namespace cmpg
