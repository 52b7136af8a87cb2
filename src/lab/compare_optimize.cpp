// Whole optimisations of the same parameters by different methods, side by side in time.
#include "lab/compare_optimize.h"

#include "optimize/recovery_run.h"
#include "session/render_options.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace cmpg {
namespace {

constexpr std::uint32_t kImagePass = 7;   // random numbers of the images compared at the end
constexpr std::uint32_t kImageSpp = 64;

std::vector<View> viewsOf(const CompareSubject& subject) {
    std::vector<View> views{subject.view};
    views.insert(views.end(), subject.furtherViews.begin(), subject.furtherViews.end());
    return views;
}

// One optimisation with a scene of its own.
class Run {
  public:
    Run(Device& device, const CompareSubject& subject, const CompareMethod& method, OptimizeConfig config)
        : subject_(subject), scene_(subject.scene), run_(device, scene_, renderConfig(subject, method), guidedOptions(method.options)) {
        config.targets = {subject.target};
        config.targets.insert(config.targets.end(), subject.furtherTargets.begin(), subject.furtherTargets.end());
        run_.begin({.config = std::move(config),
                    .views = viewsOf(subject),
                    .learn = method.learns(),
                    .freeze = subject.options.freeze.value_or(~0u)});
        run_.renderer().prepare({run_.imageMode(), Renderer::Mode::Reverse}); // compilation is no part of what is timed
        run_.passes().prepare({run_.imageMode(), Renderer::Mode::Reverse});
        curve_.push_back({0, 0, meanSquaredParameterError(values(), subject.truth)});
    }

    void step() {
        const Stopwatch watch;
        run_.optimization().step();
        seconds_ += watch.seconds();
        curve_.push_back({seconds_, run_.optimization().state().step, meanSquaredParameterError(values(), subject_.truth)});
    }

    std::vector<std::vector<float>> values() const {
        std::vector<std::vector<float>> result;
        for (const std::uint32_t p : subject_.parameters)
            result.push_back(scene_.parameters[p].values);
        return result;
    }
    // Against the targets, mean of the views, with the same random numbers for all methods.
    double imageError() {
        run_.passes().setLearning(false);
        double sum = 0;
        for (std::size_t v = 0; v < run_.model().views(); ++v) {
            const Image image = run_.model().render(v, kImageSpp, {.seed = subject_.seed(), .step = std::uint32_t(v), .pass = kImagePass});
            const Target& target = run_.optimization().config().targets[v];
            sum += evaluateLoss(Loss::Mse, image, target.image, target.mask).value;
        }
        return sum / double(run_.model().views());
    }
    double seconds() const { return seconds_; }
    std::uint32_t steps() const { return run_.optimization().state().step; }
    const std::vector<CurvePoint>& curve() const { return curve_; }
    const GuidedPasses& passes() const { return run_.passes(); }
    const Renderer& renderer() const { return run_.renderer(); }

  private:
    const CompareSubject& subject_;
    Scene scene_;
    RecoveryRun run_;
    double seconds_ = 0;
    std::vector<CurvePoint> curve_;
};

void advance(std::vector<std::unique_ptr<Run>>& runs, const CompareSubject& subject, const OptimizeConfig& config,
             const std::function<void(const std::string&)>& progress) {
    const std::optional<float> time = subject.options.time;
    for (;;) {
        std::size_t next = runs.size();
        for (std::size_t i = 0; i < runs.size(); ++i) {
            if (time ? runs[i]->seconds() >= double(*time) : runs[i]->steps() >= config.steps)
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
        result.error += (v - result.value) * (v - result.value) / (n * std::max(1.0, n - 1));
    result.error = std::sqrt(result.error);
    return result;
}

} // namespace

OptimizeComparison compareOptimisations(Device& device, const CompareSubject& subject, const OptimizeConfig& config, Report& report,
                                        const std::function<void(const std::string&)>& progress) {
    const std::uint32_t repetitions = subject.options.seeds.value_or(1);
    OptimizeComparison comparison;
    std::vector<std::vector<double>> parameterErrors(subject.methods.size()), imageErrors(subject.methods.size());
    for (const CompareMethod& method : subject.methods) {
        comparison.results.emplace_back();
        comparison.results.back().method = method;
    }
    for (std::uint32_t repetition = 0; repetition < repetitions; ++repetition) {
        OptimizeConfig own = config;
        own.seed = config.seed + repetition;
        std::vector<std::unique_ptr<Run>> runs;
        for (const CompareMethod& method : subject.methods)
            runs.push_back(std::make_unique<Run>(device, subject, method, own));
        if (repetition == 0) {
            comparison.initial = runs.front()->values();
            comparison.initialError = runs.front()->curve().front().error;
        }
        advance(runs, subject, own, progress);
        for (std::size_t i = 0; i < runs.size(); ++i) {
            OptimizeResult& result = comparison.results[i];
            Run& run = *runs[i];
            ++result.repetitions;
            result.steps += double(run.steps()) / repetitions;
            result.seconds += run.seconds() / repetitions;
            result.trainSeconds += run.passes().trainSeconds() / repetitions;
            parameterErrors[i].push_back(run.curve().back().error);
            imageErrors[i].push_back(run.imageError());
            if (repetition == 0) {
                result.curve = run.curve();
                result.values = run.values();
                result.chosen = describeDecision(result.method, run.passes().decision());
            }
            report.addStatistics(run.renderer().statistics());
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
        const double goal = comparison.results.front().curve.back().error;
        if (goal < comparison.initialError) // else everybody is as good before the first step
            result.secondsToFirst = secondsToReach(result.curve, goal);
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
