// Losses between an image and its target, with the adjoint: the derivative of the loss by every pixel value.
#pragma once

#include "scene/image.h"

#include <cmpg/options.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace cmpg {

struct LossTerm {
    double value, derivative; // derivative by x; 0 at the kinks
};
LossTerm lossTerm(Loss loss, double x, double y);
inline bool isSquared(Loss loss) { return loss == Loss::Mse || loss == Loss::RelativeMse; }

// Whether the mean of two estimates of a value is no darker than a clipped one, and so without loss.
inline bool isBeyondBound(double a, double b, double clipped) { return 0.5 * (a + b) >= clipped; }

struct LossResult {
    double value = 0;            // weighted mean over pixels and channels
    double error = 0;            // standard error of `value` by the noise of the image; 0 where it is not known
    double values = 0;           // pixels times channels, weighted
    Image adjoint;               // dvalue/dpixel, in the image's shape
    std::uint64_t nonFinite = 0; // pixels left out because the image is not finite there
};

// `halves`: two estimates of one image with noise of their own; the adjoint is that of their mean. Squared losses are products of a term of each,
// without bias by noise. The others are those of the mean: noise makes |x - y| larger by at most its own mean magnitude.
// `mask`: weight in [0,1] of each pixel, or empty for 1 everywhere. `clipped`: 1 for values of the target that are only lower bounds, or empty for
// none: an image that is no darker there has no loss. The sum is in a fixed order: equal inputs, equal bits, whatever
// the number of threads. Error(Input) if the sizes differ or nothing is unmasked.
LossResult evaluateLoss(Loss loss, const std::array<Image, 2>& halves, const Image& target, std::span<const float> mask = {}, std::span<const std::uint8_t> clipped = {});
// Of an image without noise, or whose noise is to be in the value.
LossResult evaluateLoss(Loss loss, const Image& image, const Image& target, std::span<const float> mask = {}, std::span<const std::uint8_t> clipped = {});
// The second derivative of a squared loss by every value of an image, whatever the image.
Image lossCurvature(Loss loss, const Image& target, std::span<const float> mask = {});

} // namespace cmpg
