// Losses between an image and its target, with the adjoint.
#include "optimize/losses.h"

#include "base/error.h"
#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kPixelsAtOnce = 1 << 14;

double sign(double x) { return double(x > 0) - double(x < 0); }

struct Totals {
    double value = 0, variance = 0, fourth = 0; // as in NoisyTerm
    std::uint64_t nonFinite = 0;
    Totals& operator+=(const Totals& other) {
        value += other.value;
        variance += other.variance;
        fourth += other.fourth;
        nonFinite += other.nonFinite;
        return *this;
    }
};

std::string sizeText(const Image& image) {
    return std::to_string(image.width) + " x " + std::to_string(image.height) + " x " + std::to_string(image.channels);
}

} // namespace

LossTerm lossTerm(Loss loss, double x, double y) {
    const double d = x - y;
    switch (loss) {
    case Loss::Mse:
        return {d * d, 2 * d};
    case Loss::L1:
        return {std::abs(d), sign(d)};
    case Loss::Smape: {
        const double s = std::abs(x) + std::abs(y) + kLossEpsilon;
        return {std::abs(d) / s, (sign(d) - std::abs(d) / s * sign(x)) / s};
    }
    case Loss::RelativeMse: {
        const double s = y * y + kLossEpsilon;
        return {d * d / s, 2 * d / s};
    }
    }
    return {0, 0};
}

namespace {

// The loss of two estimates of one value, their mean's derivative, and the variance by how they differ. `fourth`: of a squared loss, of its part that is the
// noise's alone, by the fourth power of how they differ.
struct NoisyTerm {
    double value, derivative, variance, fourth = 0;
};

NoisyTerm noisyTerm(Loss loss, double a, double b, double y) {
    const double x = 0.5 * (a + b), half = 0.5 * (a - b) * (a - b); // half: variance of a and of b
    const LossTerm mean = lossTerm(loss, x, y);
    if (!isSquared(loss))
        return {mean.value, mean.derivative, mean.derivative * mean.derivative * half / 2};
    const double unit = loss == Loss::Mse ? 1 : 1 / (y * y + kLossEpsilon);
    // The variance of (a - y) (b - y) is 2 v D^2 + v^2, with v that of a and b and D without noise; (x - y)^2 is D^2 + v / 2 on average, half^2 3 v^2 where noise
    // is normal.
    return {(a - y) * (b - y) * unit, mean.derivative, 2 * half * (x - y) * (x - y) * unit * unit, half * half / 3 * unit * unit};
}

double weightOf(std::span<const float> mask, std::size_t pixel) { return mask.empty() ? 1.0 : double(mask[pixel]); }

double sumOfWeights(std::span<const float> mask, std::size_t pixels) {
    return orderedSum<double>(pixels, kPixelsAtOnce, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t p = begin; p < end; ++p)
            sum += weightOf(mask, p);
        return sum;
    });
}

LossResult evaluate(Loss loss, const Image& image, const Image& second, const Image& target, std::span<const float> mask,
                    std::span<const std::uint8_t> clipped) {
    if (image.width != target.width || image.height != target.height || image.channels != target.channels)
        throw Error(ErrorKind::Input, "an image of " + sizeText(image) + " cannot be compared with a target of " + sizeText(target));
    if (!mask.empty() && mask.size() != image.pixels())
        throw Error(ErrorKind::Input,
                    "the mask has " + std::to_string(mask.size()) + " pixels, the image " + std::to_string(image.pixels()));

    const double total = sumOfWeights(mask, image.pixels());
    if (!(total > 0))
        throw Error(ErrorKind::Input, "no pixel of the target counts", "mask, alpha and clipping leave nothing to compare");

    const std::size_t channels = std::size_t(image.channels);
    const double norm = 1 / (total * double(channels));
    LossResult result{0, 0, 1 / norm, Image(image.width, image.height, image.channels), 0};
    const Totals totals = orderedSum<Totals>(image.pixels(), kPixelsAtOnce, [&](std::size_t begin, std::size_t end) {
        Totals sum;
        for (std::size_t p = begin; p < end; ++p) {
            const float* a = image.values.data() + p * channels;
            const float* b = second.values.data() + p * channels;
            const float* y = target.values.data() + p * channels;
            const double w = weightOf(mask, p);
            // The target is not looked at where it does not count: it may hold anything there.
            if (w == 0)
                continue;
            bool finite = true;
            for (std::size_t c = 0; c < channels; ++c)
                finite = finite && std::isfinite(a[c]) && std::isfinite(b[c]);
            if (!finite) {
                ++sum.nonFinite;
                continue;
            }
            for (std::size_t c = 0; c < channels; ++c) {
                if (!clipped.empty() && clipped[p * channels + c] && isBeyondBound(a[c], b[c], y[c]))
                    continue;
                const NoisyTerm term = noisyTerm(loss, a[c], b[c], y[c]);
                sum.value += w * term.value;
                sum.variance += w * w * term.variance;
                sum.fourth += w * w * term.fourth;
                result.adjoint.values[p * channels + c] = float(w * term.derivative * norm);
            }
        }
        return sum;
    });
    result.value = totals.value * norm;
    // A few bright paths, far off the target to both sides of it, make the loss as far negative as their mean is near it, and `variance` as small.
    result.error = std::sqrt(std::max(totals.variance, totals.fourth)) * norm;
    result.nonFinite = totals.nonFinite;
    return result;
}

} // namespace

LossResult evaluateLoss(Loss loss, const std::array<Image, 2>& halves, const Image& target, std::span<const float> mask, std::span<const std::uint8_t> clipped) {
    return evaluate(loss, halves[0], halves[1], target, mask, clipped);
}

LossResult evaluateLoss(Loss loss, const Image& image, const Image& target, std::span<const float> mask, std::span<const std::uint8_t> clipped) {
    return evaluate(loss, image, image, target, mask, clipped);
}

Image lossCurvature(Loss loss, const Image& target, std::span<const float> mask) {
    const double norm = 1 / (sumOfWeights(mask, target.pixels()) * target.channels);
    Image curvature(target.width, target.height, target.channels);
    const std::size_t channels = std::size_t(target.channels);
    for (std::size_t i = 0; i < target.values.size(); ++i) {
        const double w = weightOf(mask, i / channels), y = target.values[i];
        curvature.values[i] = w == 0 ? 0.f : float(w * norm * 2 * (loss == Loss::RelativeMse ? 1 / (y * y + kLossEpsilon) : 1));
    }
    return curvature;
}

} // namespace cmpg
