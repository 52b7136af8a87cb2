// The images of an optimisation's views: carried on from step to step, with as many samples as they need, for as many views as memory allows.
#include "optimize/curvature_passes.h"
#include "optimize/entry_loops.h"
#include "optimize/gauss_newton.h"
#include "optimize/optimize.h"
#include "optimize/residual.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cmpg {
namespace {

constexpr float kMostSamples = 1 << 20; // of a pixel, in a step
constexpr std::uint32_t kFewest = 2;    // samples of a pixel: of both halves
constexpr double kMostDifferent = 10;   // variances of two methods of images: a few bright paths make one look bad

} // namespace

std::uint32_t Optimization::perPixel(std::uint32_t samples) const {
    return std::max(std::min(samples, kFewest), std::uint32_t(std::lround(samples * config_.sampleShare)));
}

RunningImage Optimization::image(std::size_t view, const Target& target, std::uint32_t step) {
    if (!carriesImages()) {
        RunningImage image;
        image.begin(model_.renderHalves(view, perPixel(config_.spp), {config_.seed, step, kPrimalPass}, false, {}));
        return image;
    }
    PassKey key{config_.seed, std::uint32_t(view), kPrimalPass};
    RunningImage image = view < state_.images.size() ? state_.images[view] : RunningImage();
    const bool first = image.empty();
    key.firstSample = image.used;
    const std::uint32_t spp = first ? perPixel(config_.spp) : imageSamples(view, target);
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
    return std::uint32_t(std::lround(kFewest + (double(perPixel(config_.sppDifference)) - kFewest) * 0.5 * (std::max(signal, noise) + noise)));
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

} // namespace cmpg
