// How far an image is off its target.
#include "optimize/residual.h"

#include "optimize/losses.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

double toleratedLoss(Loss loss, const Target& target) {
    constexpr double kTrusted = 0.1; // of the target's mean
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < target.image.values.size(); ++i) {
        const double weight = target.mask.empty() ? 1 : double(target.mask[i / 3]), value = std::abs(double(target.image.values[i]));
        if (!std::isfinite(value) || weight == 0)
            continue;
        sum += weight * value;
        weights += weight;
    }
    const double off = weights > 0 ? kTrusted * sum / weights : 0;
    Image wrong = target.image;
    for (float& value : wrong.values)
        value += float(off);
    return evaluateLoss(loss, wrong, target.image, target.mask).value;
}

std::optional<Residual> residual(Loss loss, const RunningImage& image, const Target& target, std::span<const float> shares, double most) {
    const Image mean = image.mean();
    std::vector<float> weights = target.mask;
    if (!shares.empty()) {
        weights.resize(shares.size(), 1.f);
        for (std::size_t p = 0; p < weights.size(); ++p)
            weights[p] *= shares[p] * shares[p];
    }
    if (std::isfinite(most)) {
        weights.resize(mean.pixels(), 1.f);
        for (std::size_t p = 0; p < weights.size(); ++p) {
            double error = 0;
            for (std::size_t k = 3 * p; weights[p] > 0 && k < 3 * p + 3; ++k)
                if (target.clipped.empty() || !target.clipped[k])
                    error += lossTerm(loss, mean.values[k], target.image.values[k]).value / 3;
            if (error > most)
                weights[p] *= float(most / error);
        }
    }
    if (!weights.empty() && !std::any_of(weights.begin(), weights.end(), [](float weight) { return weight > 0; }))
        return std::nullopt;
    return Residual{evaluateLoss(loss, mean, target.image, weights, target.clipped).value,
                    evaluateLoss(loss, image.half, target.image, weights, target.clipped).value};
}

namespace {

// What the noise of an image counts beside textures, by measurement.
double noiseFactor(double texelsPerPixel) {
    constexpr double kLeast = 0.25, kMost = 4, kPower = 3;
    if (texelsPerPixel <= 0)
        return 1;
    return texelsPerPixel < 1 ? std::max(texelsPerPixel, kLeast) : std::min(std::pow(texelsPerPixel, kPower), kMost);
}

} // namespace

double ExpectedLoss::beside(double texelsPerPixel) const {
    constexpr double kLeast = 1e-4; // of what is tolerated: targets without any noise
    const double error = std::clamp(beyond + noiseFactor(texelsPerPixel) * noise, kLeast * tolerated, tolerated);
    return error / std::max(1.0, texelsPerPixel / kTexelsOfPrior);
}

ExpectedLoss expectedLoss(Loss loss, const RunningImage& image, const Target& target, std::span<const float> shares, double tolerated) {
    const bool squared = isSquared(loss);
    const double largest = squared ? 1000 : 30; // times what is tolerated: three times the target's mean
    const std::optional<Residual> found = residual(loss, image, target, shares, largest * tolerated);
    if (!found)
        return {.beyond = tolerated, .tolerated = tolerated};
    const double noise = squared ? 2 * (found->whole - found->beyond) : 0;
    return {.noise = noise, .beyond = squared ? 2 * std::max(0.0, found->beyond) : found->whole, .tolerated = tolerated};
}

} // namespace cmpg
