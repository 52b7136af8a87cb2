// An optimisation: parameters of a scene move until its images match their targets.
#include "optimize/optimize.h"

#include "base/error.h"
#include "base/stopwatch.h"
#include "optimize/curvature_passes.h"
#include "optimize/entry_loops.h"
#include "optimize/gauss_newton.h"
#include "optimize/loaded_target.h"
#include "optimize/noise_weights.h"
#include "optimize/ordered_sum.h"
#include "optimize/residual.h"
#include "optimize/unseen_texels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>

namespace cmpg {
namespace {

constexpr float kMostSamples = 1 << 20; // of a pixel, in a step
constexpr double kMostDifferent = 10;   // variances of two methods of images: a few bright paths make one look bad

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
    if (parameter.kind == SlotKind::Normal)
        return 0;
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
        if (state_.moments.size() < parameters_.size())
            state_.moments.push_back(initialMoments(config_.optimizer, parameter));
    }
    findConstants(allowed && (config_.viewsPerStep == 0 || config_.viewsPerStep >= model_.views()));
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
    state_.history.back() = recordOf(report); // with the seconds of the update
    return report;
}

double Optimization::nextWork() const {
    return double(viewOrder().viewsOf(state_.step).size()) * double(measuresAnyDiagonal() ? 1 + curvatureGroups().size() : 1);
}

RunningImage Optimization::image(std::size_t view, const Target& target, std::uint32_t step) {
    if (!carriesImages()) {
        RunningImage image;
        image.begin(model_.renderHalves(view, config_.spp, {config_.seed, step, kPrimalPass}, false, {}));
        return image;
    }
    PassKey key{config_.seed, std::uint32_t(view), kPrimalPass};
    RunningImage image = view < state_.images.size() ? state_.images[view] : RunningImage();
    const bool first = image.empty();
    key.firstSample = image.used;
    const std::uint32_t spp = first ? config_.spp : imageSamples(view, target);
    const Sampling method = model_.imageMethod();
    if (!first) {
        setImageValues(view);
        if (const double before = model_.imageVariance(image.method), now = model_.imageVariance(method); method != image.method && before > 0 && now > 0)
            image.changeMethod(method, std::clamp(now / before, 1 / kMostDifferent, kMostDifferent));
    }
    // Each pixel has one sequence of samples for all steps.
    const std::vector<std::uint32_t> counts = countsOf(view, spp);
    ImageHalves halves = model_.renderHalves(view, spp, key, true, {counts, image.samples});
    if (first)
        image.begin(std::move(halves), method);
    else
        image.advance(halves, shares_[view], changeSquared(view));
    return image;
}

std::uint32_t Optimization::imageSamples(std::size_t view, const Target& target) const {
    // Differences of images are noisy while steps are long, which they are while gradients are signal.
    double signal = newton() ? 0 : 1;
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        if (method(i) == OptimizerKind::GaussNewton)
            signal = std::max(signal, signalShare(state_.moments[i].noise[0]));
    double noise = 0; // the share of the image's noise in what steps lower
    if (isSquared(config_.loss)) {
        const std::optional<Residual> found = residual(config_.loss, state_.images[view], target, shares_[view]);
        noise = found && found->whole > 0 ? std::clamp(1 - found->beyond / found->whole, 0.0, 1.0) : 0;
    }
    constexpr double kLeast = 2; // of both halves
    return std::uint32_t(std::lround(kLeast + (config_.sppDifference - kLeast) * 0.5 * (std::max(signal, noise) + noise)));
}

// The model's second values: those of the view's image.
void Optimization::setImageValues(std::size_t view) {
    if (second_ == state_.imageValues[view])
        return;
    second_ = state_.imageValues[view];
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        model_.setSecondValues(parameters_[i], second_->values[i]);
}

// Mean square of how far the values are from those of the view's image, in their units; where the curvature is known weighed by it: what images do not answer
// to, such as texels that no camera sees, changes none.
double Optimization::changeSquared(std::size_t view) const {
    double all = 0, count = 0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        const std::vector<float>&now = scene_.parameters[parameters_[i]].values, &before = state_.imageValues[view]->values[i];
        const std::vector<float>& curvature = state_.moments[i].second;
        const bool weighs = method(i) == OptimizerKind::GaussNewton && curvature.size() == now.size();
        const double unit = state_.moments[i].unit;
        const auto weight = [&](std::size_t k) { return weighs ? double(curvature[k]) : 1.0; };
        const double weights = sumOfEntries(now.size(), weight);
        const double sum = sumOfEntries(now.size(), [&](std::size_t k) {
            const double d = (double(now[k]) - before[k]) / unit;
            return weight(k) * d * d;
        });
        if (weights > 0)
            all += sum / weights * double(now.size());
        count += double(now.size());
    }
    return count > 0 ? all / count : 0;
}

std::vector<std::uint32_t> Optimization::countsOf(std::size_t view, std::uint32_t spp) const {
    if (view >= shares_.size() || shares_[view].empty())
        return {};
    std::vector<std::uint32_t> counts;
    for (const float share : shares_[view])
        counts.push_back(1 + std::uint32_t(std::min(0.5f + std::max(0.f, 0.5f * float(spp) - 1) * share, kMostSamples)));
    return counts;
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
            information_[i] += loss.values / expected.beside(config_.texelsPerPixel.empty() ? 0 : config_.texelsPerPixel[i]) / viewShare_;
    }
    report.samples += image.paths;

    const ScopedTime time(report.secondsGradient);
    const PassKey key{config_.seed, step, kGradientPass};
    report.samples += newton() ? model_.reverseHalves(view, config_.sppGradient, key, loss.adjoint, gradients_, noise_)
                               : model_.reverse(view, config_.sppGradient, key, loss.adjoint, gradients_);
    report.concentration = std::max(report.concentration, model_.concentration());
    if (!carriesImages())
        return;
    if (view >= carriedViews())
        image.drop();
    images_.emplace_back(view, std::move(image));
}

// Not where constants step by their whole curvature, which is that of all pixels alike, nor for the shape of lobes: the pixels of highlights are the noisiest,
// and tell most of it.
bool Optimization::weighsByNoise() const {
    return newton() && constants_.empty() &&
           std::none_of(parameters_.begin(), parameters_.end(), [&](std::uint32_t p) { return shapesLobe(scene_.parameters[p].kind); });
}

// One order for all of a run.
ViewOrder Optimization::viewOrder() const {
    constexpr std::size_t kFewest = 4; // views of which the first steps see one: of fewer all are as good
    const std::size_t views = model_.views();
    const bool grows = config_.viewsPerStep == 0 && views >= kFewest && newton() && constants_.empty();
    return {config_.seed, views, config_.viewsPerStep > 0 ? config_.viewsPerStep : grows ? 0 : std::uint32_t(views)};
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
        moments.expected = moments.seen ? expectUnseen(scene_.parameters[parameters_[i]], *moments.seen) : nullptr;
}

void Optimization::sumUp(StepReport& report) {
    const ScopedTime time(report.secondsUpdate);
    report.rate = slotRate(config_.optimizer, scene_.parameters[parameters_[0]].kind) * rateFactor() * state_.moments[0].unit;
    std::uint64_t finite = 0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        TotalVariationBound& known = known_.emplace_back(parameter);
        const auto know = [&](double weight, const DifferenceCost& cost, const ExpectedDifferences& expected) {
            report.regularizer += addTotalVariation(parameter, weight, gradients_[i], cost, expected);
            if (method(i) == OptimizerKind::GaussNewton && parameter.entries() > parameter.channels)
                known.add(parameter, weight, cost, expected);
        };
        if (config_.totalVariation != 0)
            know(config_.totalVariation, kTotalVariation, {});
        if (const double unit = priorUnit(parameter); config_.prior > 0 && information_[i] > 0 && unit > 0) {
            guessUnseen(i);
            static const ExpectedDifferences alike;
            const std::shared_ptr<const ExpectedDifferences>& expected = state_.moments[i].expected;
            know(config_.prior / information_[i] * double(parameter.entries()) / unit, {kPriorCost.epsilon * unit, kPriorCost.unit * unit}, expected ? *expected : alike);
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
    curvature_.clear(); // before the update takes memory
    peak_.clear();
    if (carriesImages())
        keepImages();
    state_.losses = std::move(losses_);
    if (state_.step >= config_.warmUp) {
        stepConstants(factor);
        for (std::size_t i = 0; i < parameters_.size(); ++i)
            report.dropped += isConstant(i) ? 0 : move(i, factor);
        raiseToFloors();
    }
    state_.history.push_back(recordOf(report));
    ++state_.step;
}

// A value below its floor has no derivative, and would stay there for good.
void Optimization::raiseToFloors() {
    constexpr float kAbove = 1.001f;
    for (const std::uint32_t p : parameters_)
        if (const float least = kAbove * scene_.floorOf(p); least > 0)
            for (float& value : scene_.parameters[p].values)
                value = std::max(value, least);
}

// The first of the views: their images, and the values that these are of, stay in memory. Where steps do not see all views, images are of values of
// several steps. Those of the other views begin anew every time.
std::size_t Optimization::carriedViews() const {
    std::size_t values = 0;
    for (const std::uint32_t p : parameters_)
        values += scene_.parameters[p].values.size() * sizeof(float);
    const bool shared = seesAll();
    std::size_t bytes = shared ? values : 0, count = 0;
    for (; count < model_.views(); ++count) {
        const auto [width, height] = model_.size(count);
        bytes += RunningImage::bytes(std::size_t(width) * std::size_t(height)) + (shared ? 0 : values);
        if (bytes > config_.imageBytes)
            break;
    }
    return std::max<std::size_t>(count, 1);
}

// The step's images, with the values that they are of.
void Optimization::keepImages() {
    auto now = std::make_shared<StepValues>();
    for (const std::uint32_t p : parameters_)
        now->values.push_back(scene_.parameters[p].values);
    state_.images.resize(model_.views());
    state_.imageValues.resize(model_.views());
    for (auto& [view, image] : images_) {
        const bool kept = !image.empty();
        state_.images[view] = std::move(image);
        state_.imageValues[view] = kept ? now : nullptr;
        if (!kept)
            state_.pixelShares[view] = std::vector<float>();
    }
    images_.clear();
    second_.reset();
}

std::uint64_t Optimization::move(std::size_t i, double factor) {
    Parameter& parameter = scene_.parameters[parameters_[i]];
    Moments& moments = state_.moments[i];
    if (method(i) == OptimizerKind::GaussNewton) {
        const double unit = emitsLight(parameter.kind) ? std::max(double(moments.unit), priorUnit(parameter)) : moments.unit; // light may have begun too dark
        return updateByGaussNewton(slotRate(config_.optimizer, parameter.kind) * factor * unit, {gradients_[i], std::move(noise_[i]), viewShare_}, known_[i], moments, parameter,
                                   emitsLight(parameter.kind) ? unit : 0);
    }
    const std::uint32_t start = std::max(moments.start, config_.warmUp); // before which moments stand still
    return updateParameter(config_.optimizer, state_.step - start, factor, gradients_[i], moments, parameter);
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
    const bool begun = !state.history.empty();
    bool fits = values.size() == parameters_.size() && gradients.size() == (begun ? parameters_.size() : 0) && state.moments.size() == parameters_.size();
    for (std::size_t i = 0; fits && i < parameters_.size(); ++i) {
        const std::size_t entries = scene_.parameters[parameters_[i]].entries();
        const Moments& moments = state.moments[i];
        fits = values[i].size() == entries && (!begun || gradients[i].size() == entries) && moments.first.size() == entries &&
               moments.second.size() == state_.moments[i].second.size() && (moments.peak.empty() || moments.peak.size() == entries) &&
               (!moments.seen || moments.seen->fits(scene_.parameters[parameters_[i]])) && !moments.noise.empty() &&
               (moments.noise[0].squares.empty() || moments.noise[0].squares.size() == entries);
    }
    fits = fits && state.imageValues.size() == state.images.size() && (state.images.empty() || state.images.size() == model_.views());
    for (std::size_t view = 0; fits && view < state.images.size(); ++view) {
        fits = state.images[view].empty() == !state.imageValues[view];
        for (std::size_t i = 0; fits && state.imageValues[view] && i < values.size(); ++i)
            fits = state.imageValues[view]->values.size() == values.size() && state.imageValues[view]->values[i].size() == values[i].size();
    }
    const std::size_t constants = constantUnits().size();
    const ConstantCurvature& curvature = state.constants;
    fits = fits && (curvature.empty() || curvature.matrix.size() == constants * constants) && curvature.noise.size() == curvature.matrix.size() &&
           curvature.others.size() == (curvature.empty() ? 0 : constants) && curvature.at.size() == curvature.others.size();
    const CarriedGradient& carried = state.carried;
    fits = fits && (carried.mean.empty() || carried.mean.size() == constants) && carried.variance.size() == carried.mean.size() &&
           carried.squares.size() == carried.mean.size() && carried.at.size() == carried.mean.size();
    fits = fits && (state.losses.empty() || state.losses.size() == model_.views());
    fits = fits && (state.pixelShares.empty() || state.pixelShares.size() == model_.views());
    for (std::size_t view = 0; fits && view < model_.views(); ++view) {
        const auto [width, height] = model_.size(view);
        if (!state.images.empty() && !state.images[view].empty())
            fits = state.images[view].half[0].width == width && state.images[view].half[0].height == height;
        if (!state.pixelShares.empty())
            fits = fits && (state.pixelShares[view].empty() || state.pixelShares[view].size() == std::size_t(width) * std::size_t(height));
    }
    if (!fits)
        throw Error(ErrorKind::Input, "what was kept of the run has other parameters", "their number, their sizes or the optimiser changed");
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

Image Optimization::render(std::size_t view, std::uint32_t spp) {
    return model_.picture(view, spp, pictureKey(config_.seed, view));
}

} // namespace cmpg
