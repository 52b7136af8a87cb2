// The shapes of lobes, tried over all of their range. A loss has several minima by a roughness: a polished ball may look less like one half as rough than
// like a dull one, and no gradient leads from there. So now and then a constant goes where the image is surely nearer to its target, and a map begins
// anew there, with all texels alike.
#include "optimize/shape_scan.h"

#include "base/stopwatch.h"
#include "optimize/curvature_passes.h"
#include "optimize/loaded_target.h"
#include "optimize/optimize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace cmpg {
namespace {

constexpr std::uint32_t kScanSpp = 2; // of one of a round's two images
// After all views were seen so often, when what else is recovered is about there, and ever more rarely.
constexpr std::uint32_t kFirstScan = 4, kScanGrowth = 4;
// Of a range of 1. Narrow lobes, near 0, change faster.
constexpr std::array kTried{0.07f, 0.2f, 0.4f, 0.65f, 0.9f};
constexpr float kNear = 0.07f; // what is tried and is no farther away is left to gradients
// In standard errors: where the loss falls so much, surely; and where more rounds may tell.
constexpr double kSure = 4, kLikely = 2;
constexpr std::uint32_t kMostRounds = 8;
constexpr std::size_t kMostScanned = std::size_t(1) << 20; // texels, which every trial uploads
constexpr std::size_t kMostKinds = 2; // of maps that are recovered: of three each can stand in for what another lacks

std::vector<float> valuesToTry(const Parameter& parameter, float least) {
    const float mean = std::accumulate(parameter.values.begin(), parameter.values.end(), 0.f) / float(parameter.values.size());
    std::vector<float> values;
    for (const float share : kTried)
        if (const float value = std::clamp(share * parameter.highest(), least, parameter.highest()); std::abs(value - mean) > kNear * parameter.highest())
            values.push_back(value);
    return values;
}

double lossOf(const ImageHalves& halves, const Target& target, const Image& weight, std::size_t k) {
    const double a = halves.half[0].image.values[k], b = halves.half[1].image.values[k], y = target.image.values[k];
    if (!target.clipped.empty() && target.clipped[k] && isBeyondBound(a, b, y))
        return 0;
    return 0.5 * weight.values[k] * (a - y) * (b - y);
}

} // namespace

void ShapeGain::add(const std::array<ImageHalves, 2>& now, const std::array<ImageHalves, 2>& tried, const Target& target, const Image& weight) {
    const auto channels = std::size_t(weight.channels);
    for (std::size_t p = 0; p < weight.pixels(); ++p) {
        std::array<double, 2> gain{};
        for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t k = p * channels; k < (p + 1) * channels; ++k)
                gain[i] += lossOf(now[i], target, weight, k) - lossOf(tried[i], target, weight, k);
        const double mean = 0.5 * (gain[0] + gain[1]), half = 0.5 * (gain[0] - gain[1]);
        if (!std::isfinite(mean))
            continue;
        sum_ += mean;
        variance_ += half * half;
    }
}

double ShapeGain::error() const { return std::sqrt(variance_) / rounds_; }

std::size_t Optimization::movedKinds() const {
    const std::vector<CurvatureGroup> groups = curvatureGroups();
    return std::size_t(std::count_if(groups.begin(), groups.end(), [](const CurvatureGroup& group) { return group.axis == 0; }));
}

bool Optimization::canScan(std::size_t i) const {
    const Parameter& parameter = scene_.parameters[parameters_[i]];
    const auto isMapToScan = [&] { return usesDiagonal(i) && parameter.entries() <= kMostScanned && movedKinds() <= kMostKinds; };
    return shapesLobe(parameter.kind) && (isConstant(i) || isMapToScan());
}

std::optional<std::size_t> Optimization::scannedAfter(std::uint32_t steps) const {
    const ViewOrder order = viewOrder();
    std::uint32_t place = 0;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        if (!canScan(i))
            continue;
        const std::uint32_t first = std::max(state_.moments[i].start, config_.warmUp) + place++;
        if (steps <= first || steps >= config_.steps)
            continue;
        const std::uint64_t seen = order.wholeOrders(first, steps), before = order.wholeOrders(first, steps - 1);
        for (std::uint64_t at = kFirstScan; at <= seen; at *= kScanGrowth)
            if (before < at)
                return i;
    }
    return {};
}

void Optimization::scanShape(StepReport& report) {
    const std::optional<std::size_t> scanned = scannedAfter(state_.step);
    if (!scanned)
        return;
    const ScopedTime time(report.secondsGradient);
    const std::uint32_t index = parameters_[*scanned];
    Parameter& parameter = scene_.parameters[index];
    const std::vector<float> now = parameter.values; // which the model's setParameter() changes
    const std::vector<float> tried = valuesToTry(parameter, std::max(parameter.lowest(), raisedFloorOf(index)));
    // Images in difference to themselves: the kernels of a step's images.
    for (const std::uint32_t p : parameters_)
        model_.setSecondValues(p, scene_.parameters[p].values);
    std::vector<ShapeGain> gains(tried.size());
    const auto round = [&](std::uint32_t number, std::span<const std::size_t> views, std::size_t first, std::size_t end) {
        for (const std::size_t view : views) {
            const LoadedTarget target(config_.targets[view]);
            const Image weight = lossCurvature(config_.loss, target->image, target->mask);
            const auto images = [&](std::span<const float> values) {
                model_.setParameter(index, values);
                std::array<ImageHalves, 2> both;
                for (std::uint32_t i = 0; i < 2; ++i) {
                    const std::size_t n = ((state_.step * model_.views() + view) * kMostRounds + number) * 2 + i;
                    both[i] = model_.renderHalves(view, kScanSpp, scanKey(config_.seed, std::uint32_t(n)), true, {});
                    report.samples += 2 * std::uint64_t(both[i].samples) * weight.pixels();
                }
                return both;
            };
            const std::array<ImageHalves, 2> before = images(now);
            for (std::size_t i = first; i < end; ++i)
                gains[i].add(before, images(std::vector<float>(now.size(), tried[i])), *target, weight);
        }
        for (std::size_t i = first; i < end; ++i)
            gains[i].endRound();
    };
    std::size_t best = 0;
    bool sure = false;
    try {
        // Where a step sees some of the views, these say what may be worth trying, and all views whether it is.
        std::vector<std::size_t> views = viewOrder().viewsOf(state_.step);
        round(0, views, 0, tried.size());
        const auto likely = [](const ShapeGain& gain) { return gain.mean() - kLikely * gain.error(); };
        best = std::size_t(std::ranges::max_element(gains, {}, likely) - gains.begin());
        ShapeGain& gain = gains[best];
        const auto isSure = [&] { return gain.mean() > kSure * gain.error(); };
        std::uint32_t number = 1;
        if (views.size() < model_.views() && likely(gain) > 0) {
            views.resize(model_.views());
            std::iota(views.begin(), views.end(), std::size_t(0));
            gain = {};
            round(number++, views, best, best + 1);
        }
        for (; number < kMostRounds && !isSure() && likely(gain) > 0; ++number)
            round(number, views, best, best + 1);
        sure = views.size() == model_.views() && isSure();
    } catch (...) {
        parameter.values = now;
        model_.setParameter(index, now);
        throw;
    }
    second_.reset();
    parameter.values = sure ? std::vector<float>(now.size(), tried[best]) : now;
    model_.setParameter(index, parameter.values);
    if (!sure)
        return;
    if (Moments& moments = state_.moments[*scanned]; !isConstant(*scanned)) { // of constants it is seen that they have moved
        moments = initialMoments(config_.optimizer, parameter);
        moments.start = state_.step;
    }
    for (RunningImage& image : state_.images) // of what is no more
        image.drop();
    state_.imageValues.assign(state_.imageValues.size(), nullptr);
    state_.pixelShares.assign(state_.pixelShares.size(), {});
}

} // namespace cmpg
