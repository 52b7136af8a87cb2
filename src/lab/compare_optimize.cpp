// Whole optimisations of the same parameters by different methods, side by side in time.
#include "lab/compare_optimize.h"

#include "base/log.h"
#include "session/library_options.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace cmpg {
namespace {

constexpr std::uint32_t kImageSpp = 64;

// Without how a method draws paths.
v1::RecoveryOptions optionsOf(const CompareSubject& subject) {
    Options own = subject.options;
    own.mode = compareModeName(CompareMode::Optimize); // whatever else is compared: defaults of samples are those of steps
    v1::RecoveryOptions options = recoveryOptions(own, 0);
    options.parameters = subject.session.parameters;
    return options;
}

// One optimisation.
class Run {
  public:
    Run(CompareSubject& subject, const CompareMethod& method, v1::RecoveryOptions options)
        : subject_(subject), recovery_(make(subject, method, std::move(options))) {
        recovery_.prepare(); // compilation is no part of what is timed
        curve_.push_back({0, 0, meanSquaredParameterError(values(), subject.truth)});
    }

    void step() {
        const double compiled = subject_.session.compileSeconds();
        const Stopwatch watch;
        recovery_.step();
        const double seconds = watch.seconds(), compiling = subject_.session.compileSeconds() - compiled; // of a method of sampling that is tried first now
        seconds_ += std::max(0.0, seconds - compiling); // some of it beside other work, so that all of it may be more than the step took
        curve_.push_back({seconds_, steps(), meanSquaredParameterError(values(), subject_.truth)});
    }

    std::vector<std::vector<float>> values() const {
        std::vector<std::vector<float>> result;
        for (const std::string& name : subject_.session.parameters)
            result.push_back(recovery_.values(name));
        return result;
    }
    // Against the targets, mean of the views, with the same random numbers for all methods.
    double imageError() {
        double sum = 0;
        for (std::size_t v = 0; v < subject_.targets.size(); ++v)
            sum += v1::lossOf(Loss::Mse, recovery_.image(v, kImageSpp), subject_.targets[v]).value;
        return sum / double(subject_.targets.size());
    }
    double seconds() const { return seconds_; }
    std::uint32_t steps() const { return recovery_.steps(); }
    const std::vector<CurvePoint>& curve() const { return curve_; }
    v1::PassReport report() const { return recovery_.report(); }

  private:
    static v1::Recovery make(CompareSubject& subject, const CompareMethod& method, v1::RecoveryOptions options) {
        options.paths = subject.paths(method);
        return {subject.session.openDevice(), subject.session.scene, subject.targets, options};
    }

    const CompareSubject& subject_;
    v1::Recovery recovery_;
    double seconds_ = 0;
    std::vector<CurvePoint> curve_;
};

void advance(std::vector<std::unique_ptr<Run>>& runs, const CompareSubject& subject, std::uint32_t steps,
             const std::function<void(const std::string&)>& progress) {
    const std::optional<float> time = subject.options.time;
    for (;;) {
        std::size_t next = runs.size();
        for (std::size_t i = 0; i < runs.size(); ++i) {
            if (time ? runs[i]->seconds() >= double(*time) : runs[i]->steps() >= steps)
                continue;
            const auto spent = [&](const Run& r) { return time ? r.seconds() : double(r.steps()); };
            if (next == runs.size() || spent(*runs[i]) < spent(*runs[next]))
                next = i;
        }
        if (next == runs.size())
            return;
        runs[next]->step();
        char text[160];
        std::snprintf(text, sizeof text, "%s: step %u, %.1f s, parameter error %.4g", subject.methods[next].name.c_str(),
                      runs[next]->steps(), runs[next]->seconds(), runs[next]->curve().back().error);
        progress(text);
    }
}

Uncertain meanOf(const std::vector<double>& values) {
    Uncertain result;
    const double n = double(values.size());
    for (const double v : values)
        result.value += v / n;
    for (const double v : values)
        result.error += (v - result.value) * (v - result.value);
    result.error = values.size() < 2 ? std::numeric_limits<double>::quiet_NaN() : std::sqrt(result.error / (n * (n - 1)));
    return result;
}

} // namespace

OptimizeComparison compareOptimisations(CompareSubject& subject, const std::function<void(const std::string&)>& progress) {
    const std::uint32_t repetitions = subject.options.seeds.value_or(1);
    OptimizeComparison comparison;
    comparison.options = optionsOf(subject);
    comparison.steps = std::min(comparison.options.steps, subject.options.stopAfter.value_or(comparison.options.steps));
    std::vector<std::vector<double>> parameterErrors(subject.methods.size()), imageErrors(subject.methods.size());
    for (const CompareMethod& method : subject.methods) {
        comparison.results.emplace_back();
        comparison.results.back().method = method;
    }
    for (std::uint32_t repetition = 0; repetition < repetitions; ++repetition) {
        v1::RecoveryOptions own = comparison.options;
        own.seed += repetition;
        std::vector<std::unique_ptr<Run>> runs;
        for (const CompareMethod& method : subject.methods)
            runs.push_back(std::make_unique<Run>(subject, method, own));
        if (repetition == 0) {
            comparison.initial = runs.front()->values();
            comparison.initialError = runs.front()->curve().front().error;
            if (comparison.initialError == 0)
                logWarn("the parameters begin at the values that errors are taken from, so all that differs is noise: --set another start");
        }
        advance(runs, subject, comparison.steps, progress);
        const double goal = runs.front()->curve().back().error;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            OptimizeResult& result = comparison.results[i];
            Run& run = *runs[i];
            ++result.repetitions;
            result.steps += double(run.steps()) / repetitions;
            result.seconds += run.seconds() / repetitions;
            const v1::PassReport passes = run.report();
            result.trainSeconds += passes.learningSeconds / repetitions;
            parameterErrors[i].push_back(run.curve().back().error);
            imageErrors[i].push_back(run.imageError());
            if (i > 0 && goal < comparison.initialError) // else everybody is as good before the first step
                if (const std::optional<double> seconds = secondsToReach(run.curve(), goal))
                    result.secondsToFirst.push_back(*seconds);
            if (repetition == 0) {
                result.curve = run.curve();
                result.values = run.values();
                result.chosen = describeDecision(result.method, passes);
            }
            subject.session.add(passes);
        }
    }
    for (std::size_t i = 0; i < comparison.results.size(); ++i) {
        OptimizeResult& result = comparison.results[i];
        result.parameterError = meanOf(parameterErrors[i]);
        result.imageError = meanOf(imageErrors[i]);
        const Uncertain& first = comparison.results.front().parameterError;
        result.ratio = {first.value / result.parameterError.value, 0};
        if (i == 0)
            continue;
        result.ratio.error =
            result.ratio.value * std::hypot(first.error / first.value, result.parameterError.error / result.parameterError.value);
    }
    return comparison;
}

double meanSquaredParameterError(const std::vector<std::vector<float>>& values, const std::vector<std::vector<float>>& truth) {
    double sum = 0, count = 0;
    for (std::size_t p = 0; p < values.size(); ++p)
        for (std::size_t i = 0; i < values[p].size(); ++i) {
            const double deviation = double(values[p][i]) - double(truth[p][i]);
            sum += deviation * deviation;
            ++count;
        }
    return sum / count;
}

std::optional<double> secondsToReach(const std::vector<CurvePoint>& curve, double error) {
    for (const CurvePoint& point : curve)
        if (point.error <= error)
            return point.seconds;
    return {};
}

} // namespace cmpg
