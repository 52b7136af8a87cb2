// An optimisation: parameters of a scene move until its images match their targets.
#include "optimize/optimize.h"

#include "base/error.h"
#include "base/stopwatch.h"
#include "optimize/ordered_sum.h"
#include "optimize/regularizer.h"
#include "optimize/view_order.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::uint32_t kPrimalPass = 0, kGradientPass = 1;

struct SquareSum {
    double squares = 0;
    std::uint64_t finite = 0;
    SquareSum& operator+=(const SquareSum& other) {
        squares += other.squares;
        finite += other.finite;
        return *this;
    }
};

SquareSum squareSum(std::span<const double> gradient) {
    return orderedSum<SquareSum>(gradient.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        SquareSum sum;
        for (std::size_t i = begin; i < end; ++i)
            if (std::isfinite(gradient[i])) {
                sum.squares += gradient[i] * gradient[i];
                ++sum.finite;
            }
        return sum;
    });
}

// The loss of an image that is wrong by kTrusted of the target's root mean square everywhere.
double toleratedLoss(Loss loss, const Target& target) {
    constexpr double kTrusted = 0.02;
    SquareSum sum;
    for (const float value : target.image.values)
        if (std::isfinite(value)) {
            sum.squares += double(value) * value;
            ++sum.finite;
        }
    const double off = kTrusted * std::sqrt(sum.squares / double(std::max<std::uint64_t>(1, sum.finite)));
    Image wrong = target.image;
    for (float& value : wrong.values)
        value += float(off);
    return evaluateLoss(loss, wrong, target.image, target.mask).value;
}

// Light has no range to measure differences by, and nothing is known of those of normals.
bool hasPrior(const Parameter& parameter) { return parameter.kind != SlotKind::Normal && std::isfinite(parameter.highest()); }

} // namespace

StepRecord recordOf(const StepReport& report) {
    double squares = 0;
    for (const double norm : report.gradientNorm)
        squares += norm * norm;
    return {report.loss,           report.lossError,      report.regularizer,   report.rate,        report.secondsPrimal, report.secondsGradient,
            report.secondsUpdate, std::sqrt(squares), report.dropped};
}

PassKey pictureKey(std::uint64_t seed, std::size_t view) {
    return {seed, ~0u - std::uint32_t(view), kPrimalPass};
}

Optimization::Optimization(ImageModel& model, Scene& scene, OptimizeConfig config, std::vector<std::uint32_t> parameters,
                           OptimizeState start)
    : model_(model), scene_(scene), config_(std::move(config)), parameters_(std::move(parameters)), state_(std::move(start)) {
    if (config_.targets.size() != model_.views())
        throw Error(ExitCode::Usage,
                    std::to_string(model_.views()) + " views but " + std::to_string(config_.targets.size()) + " targets", {},
                    "give one target per view");
    for (std::size_t view = 0; view < model_.views(); ++view)
        requireSize(config_.targets[view], model_.size(view).first, model_.size(view).second);
    for (const Target& target : config_.targets)
        tolerance_.push_back(config_.prior > 0 ? toleratedLoss(config_.loss, target) : 0);
    if (parameters_.empty())
        throw Error(ExitCode::Usage, "there is nothing to optimise", {}, "name a parameter with --param");
    for (const std::uint32_t index : parameters_) {
        Parameter& parameter = scene_.parameters.at(index);
        parameter.materialise();
        if (state_.moments.size() < parameters_.size())
            state_.moments.push_back(initialMoments(config_.optimizer, parameter));
    }
}

void Optimization::setSamples(std::uint32_t spp, std::uint32_t sppGradient) {
    config_.spp = spp;
    config_.sppGradient = sppGradient;
}

StepReport Optimization::step() {
    StepReport report;
    report.step = state_.step;
    gradients_.resize(parameters_.size());
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        gradients_[i].assign(scene_.parameters[parameters_[i]].entries(), 0.0);
    images_.clear();
    information_ = 0;
    for (std::size_t i = 0; i < state_.imageValues.size(); ++i)
        model_.setSecondValues(parameters_[i], state_.imageValues[i]);
    const std::vector<std::size_t> views = viewsOfStep(config_.seed, state_.step, model_.views(), config_.viewsPerStep);
    for (std::size_t place = 0; place < views.size(); ++place)
        addView(views[place], place, views.size(), report);
    sumUp(report);
    model_.endStep();
    applyUpdate(report);
    publish(report);
    return report;
}

RunningImage Optimization::image(std::size_t view, std::uint32_t step) {
    if (!carriesImages()) {
        RunningImage image;
        image.begin(model_.renderHalves(view, config_.spp, {config_.seed, step, kPrimalPass}, false));
        return image;
    }
    // One sequence of samples for all steps.
    PassKey key{config_.seed, std::uint32_t(view), kPrimalPass};
    const bool first = view >= state_.images.size() || state_.images[view].empty();
    RunningImage image = first ? RunningImage() : state_.images[view];
    key.firstSample = image.samples;
    ImageHalves halves = model_.renderHalves(view, first ? config_.spp : config_.sppDifference, key, true);
    if (first)
        image.begin(std::move(halves));
    else
        image.advance(halves);
    return image;
}

void Optimization::addView(std::size_t view, std::size_t place, std::size_t count, StepReport& report) {
    // Views draw numbers of their own: the same numbers in all would add their errors up.
    const auto views = std::uint32_t(count);
    const auto step = std::uint32_t(state_.step * views + place);
    const Target& target = config_.targets[view];

    RunningImage image;
    {
        const ScopedTime time(report.secondsPrimal);
        image = this->image(view, step);
    }
    LossResult loss;
    {
        const ScopedTime time(report.secondsUpdate);
        if (config_.onImage)
            config_.onImage(view, image.mean());
        loss = evaluateLoss(config_.loss, image.half, target.image, target.mask);
        if (views > 1)
            for (float& value : loss.adjoint.values)
                value /= float(views);
    }
    report.loss += loss.value / views;
    report.lossError = std::hypot(report.lossError, loss.error / views);
    report.dropped += loss.nonFinite;
    if (const double tolerance = tolerance_[view]; tolerance > 0)
        information_ += loss.values / tolerance;
    const std::uint32_t earlier = carriesImages() && view < state_.images.size() ? state_.images[view].samples : 0;
    report.samples += 2 * std::uint64_t(image.samples - earlier) * image.half[0].pixels();

    const ScopedTime time(report.secondsGradient);
    const PassKey key{config_.seed, step, kGradientPass};
    report.samples += model_.reverse(view, config_.sppGradient, key, loss.adjoint, gradients_);
    report.concentration = std::max(report.concentration, model_.concentration());
    if (carriesImages())
        images_.push_back(std::move(image));
}

double Optimization::rateFactor() const {
    const OptimizerConfig& optimizer = config_.optimizer;
    return rateFactor_ * scheduleFactor(optimizer.schedule, state_.step, config_.steps, optimizer.finalFactor);
}

void Optimization::sumUp(StepReport& report) {
    const ScopedTime time(report.secondsUpdate);
    report.rate = slotRate(config_.optimizer, scene_.parameters[parameters_[0]].kind) * rateFactor() * state_.moments[0].unit;
    std::uint64_t finite = 0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        if (config_.totalVariation != 0)
            report.regularizer += addTotalVariation(scene_.parameters[parameters_[i]], config_.totalVariation, gradients_[i]);
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        if (config_.prior > 0 && information_ > 0 && hasPrior(parameter))
            report.regularizer += addTotalVariation(parameter, config_.prior / information_ * double(parameter.entries()), gradients_[i], kPriorEpsilon);
        const SquareSum sum = squareSum(gradients_[i]);
        report.gradientNorm.push_back(std::sqrt(sum.squares));
        finite += sum.finite;
    }
    if (finite == 0)
        throw Error(ExitCode::Numerical, "no gradient of step " + std::to_string(state_.step) + " is finite",
                    "values of the scene or the target are too large, or a learning rate threw the parameters off",
                    "lower the learning rate or look at the target");
}

void Optimization::applyUpdate(StepReport& report) {
    const ScopedTime time(report.secondsUpdate);
    const double factor = rateFactor();
    state_.images = std::move(images_);
    state_.imageValues.clear();
    for (std::size_t i = 0; carriesImages() && i < parameters_.size(); ++i)
        state_.imageValues.push_back(scene_.parameters[parameters_[i]].values);
    if (state_.step >= config_.warmUp)
        for (std::size_t i = 0; i < parameters_.size(); ++i)
            report.dropped += updateParameter(config_.optimizer, state_.step - state_.moments[i].start, factor, gradients_[i], state_.moments[i],
                                              scene_.parameters[parameters_[i]]);
    state_.history.push_back(recordOf(report));
    ++state_.step;
}

void Optimization::publish(StepReport& report) {
    {
        const ScopedTime time(report.secondsUpdate);
        if (report.step >= config_.warmUp)
            for (const std::uint32_t p : parameters_)
                model_.setParameter(p, scene_.parameters[p].values);
    }
    model_.publish();
}

void Optimization::requireFits(const OptimizeState& state, const std::vector<std::vector<float>>& values,
                               const std::vector<std::vector<double>>& gradients) const {
    bool fits = values.size() == parameters_.size() && gradients.size() == parameters_.size() && state.moments.size() == parameters_.size();
    for (std::size_t i = 0; fits && i < parameters_.size(); ++i) {
        const std::size_t entries = scene_.parameters[parameters_[i]].entries();
        const Moments& moments = state.moments[i];
        fits = values[i].size() == entries && gradients[i].size() == entries && moments.first.size() == entries &&
               moments.second.size() == state_.moments[i].second.size();
    }
    fits = fits && state.imageValues.size() == (state.images.empty() ? 0 : parameters_.size()) && (state.images.empty() || state.images.size() == model_.views());
    for (std::size_t i = 0; fits && i < state.imageValues.size(); ++i)
        fits = state.imageValues[i].size() == values[i].size();
    for (std::size_t view = 0; fits && view < state.images.size(); ++view)
        fits = std::pair(state.images[view].half[0].width, state.images[view].half[0].height) == model_.size(view);
    if (!fits)
        throw Error(ExitCode::Input, "what was kept of the run has other parameters", "their number, their sizes or the optimiser changed");
}

void Optimization::restore(OptimizeState state, const std::vector<std::vector<float>>& values, std::vector<std::vector<double>> gradients) {
    requireFits(state, values, gradients);
    state_ = std::move(state);
    gradients_ = std::move(gradients);
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        scene_.parameters[parameters_[i]].values = values[i];
        model_.setParameter(parameters_[i], values[i]);
    }
}

bool Optimization::run(const std::function<void(const StepReport&)>& afterStep) {
    while (state_.step < std::min(config_.steps, config_.stopAfter)) {
        const StepReport report = step();
        if (afterStep)
            afterStep(report);
        if (config_.stop && config_.stop->load())
            return false;
    }
    return true;
}

Image Optimization::render(std::size_t view, std::uint32_t spp) {
    return model_.picture(view, spp, pictureKey(config_.seed, view));
}

} // namespace cmpg
