// An optimisation: parameters of a scene move until its images match their targets.
#include "optimize/optimize.h"

#include "base/error.h"
#include "base/stopwatch.h"
#include "optimize/curvature_passes.h"
#include "optimize/gauss_newton.h"
#include "optimize/loaded_target.h"
#include "optimize/noise_weights.h"
#include "optimize/ordered_sum.h"
#include "optimize/residual.h"
#include "optimize/tangent_plane.h"
#include "optimize/unseen_texels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace cmpg {
namespace {

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

// What the prior measures differences of texels by: their range, or, since light has none, their mean. 0: nothing is known of them.
double priorUnit(const Parameter& parameter) {
    if (!emitsLight(parameter.kind))
        return 1;
    const double sum = orderedSum<double>(parameter.values.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        return std::accumulate(parameter.values.begin() + std::ptrdiff_t(begin), parameter.values.begin() + std::ptrdiff_t(end), 0.0);
    });
    return std::isfinite(sum) ? sum / double(parameter.values.size()) : 0;
}

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
        throw Error(ErrorKind::Usage,
                    std::to_string(model_.views()) + " views but " + std::to_string(config_.targets.size()) + " targets", {},
                    "give one target per view");
    for (std::size_t view = 0; view < model_.views(); ++view)
        requireSize(config_.targets[view], model_.size(view).first, model_.size(view).second);
    for (const Target& target : config_.targets)
        tolerance_.push_back(config_.prior > 0 ? toleratedLoss(config_.loss, *LoadedTarget(target)) : 0);
    // A black target does not say how bright its view might be, and is trusted as the least bright of the others.
    double least = 0;
    for (const double tolerated : tolerance_)
        if (tolerated > 0 && (least == 0 || tolerated < least))
            least = tolerated;
    for (double& tolerated : tolerance_)
        tolerated = std::max(tolerated, least);
    if (parameters_.empty())
        throw Error(ErrorKind::Usage, "there is nothing to optimise", {}, "name a parameter", {"param"});
    const bool allowed = allowsNewton(config_);
    if (config_.optimizer.kind == OptimizerKind::GaussNewton && !allowed)
        throw Error(ErrorKind::Usage, "Gauss-Newton needs a squared loss, and images that steps carry on",
                    "the loss is no squared one, or images get no samples of differences", "take Adam, or change these",
                    {"optimizer", "loss", "spp-difference"});
    for (const std::uint32_t index : parameters_) {
        Parameter& parameter = scene_.parameters.at(index);
        methods_.push_back(methodOf(config_, parameter.kind));
        parameter.materialise();
        const double covered = config_.footprints.empty() || methods_.back() != OptimizerKind::GaussNewton ? 0 : config_.footprints[methods_.size() - 1].least;
        coarse_.push_back(covered >= 4 ? std::optional(CoarseTexture(gridOf(parameter), std::size_t(covered / 2))) : std::nullopt);
        if (state_.moments.size() < parameters_.size())
            state_.moments.push_back(initialMoments(config_.optimizer, parameter));
    }
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        if (Moments& moments = state_.moments[i]; !moments.areOf(stepGrid(i))) { // another prior has another grid
            moments.seen = nullptr;
            moments.noise.assign(1, {});
        }
    findConstants(allowed && (config_.viewsPerStep == 0 || config_.viewsPerStep >= model_.views()));
    findCoupled();
    state_.cross.resize(coupled_.size());
    restartCurvature();
}

void Optimization::setSamples(std::uint32_t spp, std::uint32_t sppGradient) {
    config_.spp = spp;
    config_.sppGradient = sppGradient;
}

StepReport Optimization::step() {
    const std::uint32_t step = state_.step;
    std::vector<std::vector<double>> before = std::exchange(gradients_, {});
    try {
        return wholeStep();
    } catch (...) {
        if (state_.step == step)
            gradients_ = std::move(before);
        throw;
    }
}

StepReport Optimization::wholeStep() {
    StepReport report;
    report.step = state_.step;
    for (const std::uint32_t p : parameters_)
        gradients_.emplace_back(scene_.parameters[p].entries(), 0.0);
    noise_ = newton() ? gradients_ : std::vector<std::vector<double>>();
    images_.clear();
    losses_ = state_.losses;
    losses_.resize(model_.views());
    known_.clear();
    information_.assign(parameters_.size(), 0.0);
    curvature_.clear();
    peak_.clear();
    shares_ = state_.pixelShares;
    shares_.resize(model_.views());
    constantCurvature_ = state_.constants;
    measureConstants(report);
    const std::vector<std::size_t> views = viewOrder().viewsOf(state_.step);
    viewShare_ = double(views.size()) / double(model_.views());
    measureCurvature(views, report);
    second_.reset();
    for (std::size_t place = 0; place < views.size(); ++place)
        addView(views[place], place, views.size(), report);
    addLosses(report);
    sumUp(report);
    model_.endStep();
    applyUpdate(report);
    publish(report);
    scanShape(report);
    state_.history.back() = recordOf(report); // with the seconds of the update
    return report;
}

double Optimization::nextWork() const {
    constexpr double kScan = 1.5;
    return double(viewOrder().viewsOf(state_.step).size()) *
           (1 + (measuresAnyDiagonal() ? double(curvatureGroups().size()) : 0) + (scannedAfter(state_.step + 1) ? kScan : 0));
}

void Optimization::addView(std::size_t view, std::size_t place, std::size_t count, StepReport& report) {
    // Views draw numbers of their own, in all steps: the same numbers would add their errors up.
    const auto views = std::uint32_t(count);
    const auto step = std::uint32_t(viewOrder().seenBefore(state_.step) + place);
    const LoadedTarget loaded(config_.targets[view]);
    const Target& target = *loaded;

    RunningImage image;
    {
        const ScopedTime time(report.secondsPrimal);
        image = this->image(view, target, step);
    }
    LossResult loss;
    {
        const ScopedTime time(report.secondsUpdate);
        if (config_.onImage)
            config_.onImage(view, image.mean());
        loss = evaluateLoss(config_.loss, image.half, target.image, target.mask, target.clipped);
        if (weighsByNoise())
            weigh(loss.adjoint, noiseWeights(config_.loss, image.half, target, loss.value));
        if (views > 1)
            for (float& value : loss.adjoint.values)
                value /= float(views);
    }
    losses_[view] = {loss.value, loss.error, true};
    report.dropped += loss.nonFinite;
    if (const double tolerated = tolerance_[view]; tolerated > 0) {
        const ExpectedLoss expected = expectedLoss(config_.loss, image, target, shares_[view], tolerated);
        for (std::size_t i = 0; i < parameters_.size(); ++i) // of all views
            information_[i] += loss.values / expected.beside(config_.footprints.empty() ? 0 : config_.footprints[i].mean) / viewShare_;
    }
    report.samples += image.paths;

    const ScopedTime time(report.secondsGradient);
    const PassKey key{config_.seed, step, kGradientPass};
    report.samples += newton() ? model_.reverseHalves(view, perPixel(config_.sppGradient), key, loss.adjoint, gradients_, noise_)
                               : model_.reverse(view, perPixel(config_.sppGradient), key, loss.adjoint, gradients_);
    report.concentration = std::max(report.concentration, model_.concentration());
    if (!carriesImages())
        return;
    if (view >= carriedViews())
        image.drop();
    images_.emplace_back(view, std::move(image));
}

// Not where constants step by their whole curvature, which is that of all pixels alike, nor where highlights tell most.
bool Optimization::weighsByNoise() const {
    return newton() && constants_.empty() &&
           std::none_of(parameters_.begin(), parameters_.end(), [&](std::uint32_t p) { return isFarFromLinear(scene_.parameters[p].kind); });
}

// One order for all of a run.
ViewOrder Optimization::viewOrder() const {
    constexpr std::size_t kFewest = 4; // views of which the first steps see one, and later ones more
    const std::size_t views = model_.views();
    if (config_.viewsPerStep > 0)
        return {config_.seed, views, config_.viewsPerStep};
    if (!newton() || !constants_.empty())
        return {config_.seed, views, std::uint32_t(views)};
    if (views >= kFewest)
        return {config_.seed, views, 0};
    // Of fewer all views are as good by a colour. By the shape of lobes many steps are needed, whichever view they see.
    const bool shapes = std::all_of(parameters_.begin(), parameters_.end(), [&](std::uint32_t p) { return shapesLobe(scene_.parameters[p].kind); });
    return {config_.seed, views, shapes ? 1 : std::uint32_t(views)};
}

void Optimization::addLosses(StepReport& report) {
    const auto known = double(std::count_if(losses_.begin(), losses_.end(), [](const ViewLoss& loss) { return loss.known; }));
    for (const ViewLoss& loss : losses_)
        if (loss.known) {
            report.loss += loss.value / known;
            report.lossError = std::hypot(report.lossError, loss.error / known);
        }
}

double Optimization::rateFactor() const {
    const OptimizerConfig& optimizer = config_.optimizer;
    return rateFactor_ * scheduleFactor(optimizer.schedule, state_.step, config_.steps, optimizer.finalFactor);
}

// What cameras see of a texture tells ever better what the rest is like: after 8 steps, 16 and so on.
void Optimization::guessUnseen(std::size_t i) {
    constexpr std::uint32_t kFirst = 8;
    Moments& moments = state_.moments[i];
    if (moments.steps >= kFirst && std::has_single_bit(moments.steps))
        moments.expected = moments.seen ? expectUnseen(scene_.parameters[parameters_[i]], *moments.seen, coarse(i)) : nullptr;
}

// The prior's weight follows from the errors of all pixels, on average. Where a texture is dim they are far smaller, and the prior would hide all that its pixels
// tell: there it weighs as much less, unless the image is noisy.
std::vector<float> Optimization::priorStrengths(std::size_t i) const {
    constexpr float kFull = 0.1f;   // of the mean light
    constexpr float kLeast = 0.01f; // the curvature that tells the light is noisy
    const std::shared_ptr<const SeenTexels>& seen = state_.moments[i].seen;
    if (!seen)
        return {};
    std::vector<float> strengths;
    for (const float light : seen->light())
        strengths.push_back(light < 0 ? 1.f : std::clamp(light / kFull, kLeast, 1.f));
    if (std::all_of(strengths.begin(), strengths.end(), [](float strength) { return strength == 1; }))
        return {};
    return coarse(i) ? coarse(i)->nearest(strengths) : strengths;
}

void Optimization::sumUp(StepReport& report) {
    const ScopedTime time(report.secondsUpdate);
    report.rate = slotRate(config_.optimizer, scene_.parameters[parameters_[0]].kind) * rateFactor() * state_.moments[0].unit;
    std::uint64_t finite = 0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        TotalVariationBound& known = known_.emplace_back(parameter);
        const auto know = [&](double weight, const DifferenceCost& cost, const ExpectedDifferences& expected, std::span<const float> strengths) {
            report.regularizer += addTotalVariation(parameter, weight, gradients_[i], cost, expected, strengths);
            if (method(i) == OptimizerKind::GaussNewton && parameter.entries() > parameter.channels)
                known.add(parameter, weight, cost, expected, strengths);
        };
        if (config_.totalVariation != 0)
            know(config_.totalVariation, kTotalVariation, {}, {});
        if (const double unit = priorUnit(parameter); config_.prior > 0 && information_[i] > 0 && unit > 0) {
            guessUnseen(i);
            static const ExpectedDifferences alike;
            const std::shared_ptr<const ExpectedDifferences>& expected = state_.moments[i].expected;
            know(config_.prior / information_[i] * double(parameter.entries()) / unit, {kPriorCost.epsilon * unit, kPriorCost.unit * unit}, expected ? *expected : alike,
                 priorStrengths(i));
        }
        const SquareSum sum = squareSum(gradients_[i]);
        report.gradientNorm.push_back(std::sqrt(sum.squares));
        finite += sum.finite;
    }
    if (finite == 0)
        throw Error(ErrorKind::Numerical, "no gradient of step " + std::to_string(state_.step) + " is finite",
                    "values of the scene or the target are too large, or a learning rate threw the parameters off",
                    "lower the learning rate or look at the target");
}

void Optimization::applyUpdate(StepReport& report) {
    const ScopedTime time(report.secondsUpdate);
    const double factor = rateFactor();
    state_.pixelShares = std::move(shares_);
    state_.constants = std::move(constantCurvature_);
    for (std::size_t i = 0; i < curvature_.size(); ++i)
        if (usesDiagonal(i))
            addDiagonal(i);
    addCrossCurvature();
    curvature_.clear(); // before the update takes memory
    peak_.clear();
    if (carriesImages())
        keepImages();
    state_.losses = std::move(losses_);
    if (state_.step >= config_.warmUp) {
        stepConstants(factor);
        for (std::size_t i = 0; i < parameters_.size(); ++i)
            report.dropped += isConstant(i) ? 0 : move(i, factor, report.loss);
        raiseToFloors();
    }
    state_.history.push_back(recordOf(report));
    ++state_.step;
}

// A value below its floor has no derivative, and would stay there for good.
float Optimization::raisedFloorOf(std::uint32_t parameter) const {
    constexpr float kAbove = 1.001f;
    return kAbove * scene_.floorOf(parameter);
}

void Optimization::raiseToFloors() {
    for (const std::uint32_t p : parameters_)
        if (const float least = raisedFloorOf(p); least > 0)
            for (float& value : scene_.parameters[p].values)
                value = std::max(value, least);
}

std::uint64_t Optimization::move(std::size_t i, double factor, double residual) {
    Parameter& parameter = scene_.parameters[parameters_[i]];
    Moments& moments = state_.moments[i];
    if (const std::vector<std::size_t>* maps = coupledWith(i))
        return maps->front() == i ? moveCoupled(std::size_t(maps - coupled_.data()), factor, residual) : 0; // all with the first
    if (method(i) == OptimizerKind::GaussNewton) {
        const double unit = emitsLight(parameter.kind) ? std::max(double(moments.unit), priorUnit(parameter)) : moments.unit; // light may have begun too dark
        return moveByGaussNewton(i, slotRate(config_.optimizer, parameter.kind) * factor * unit, emitsLight(parameter.kind) ? unit : 0);
    }
    const std::uint32_t start = std::max(moments.start, config_.warmUp); // before which moments stand still
    return updateParameter(config_.optimizer, state_.step - start, factor, gradients_[i], moments, parameter);
}

std::uint64_t Optimization::moveByGaussNewton(std::size_t i, double rate, double lightUnit) {
    Parameter& parameter = scene_.parameters[parameters_[i]];
    Moments& moments = state_.moments[i];
    if (!isNormal(i))
        return updateByGaussNewton(rate, {gradients_[i], std::move(noise_[i]), viewShare_}, known_[i], moments, parameter, lightUnit, coarse(i));
    Parameter steps = parameter;
    std::fill(steps.values.begin(), steps.values.end(), 0.f);
    std::vector<double> gradient = gradients_[i];
    toSteps(parameter.values, gradient);
    toSteps(parameter.values, noise_[i]);
    const std::uint64_t skipped = updateByGaussNewton(rate, {gradient, std::move(noise_[i]), viewShare_}, known_[i], moments, steps, 0, coarse(i));
    moveNormals(steps.values, parameter.values);
    return skipped;
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

Image Optimization::render(std::size_t view, std::uint32_t spp) {
    return model_.picture(view, spp, pictureKey(config_.seed, view), carriesImages());
}

} // namespace cmpg
