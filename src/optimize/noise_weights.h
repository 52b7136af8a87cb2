// Weights of pixels by the noise of the image around them.
#pragma once

#include "optimize/target.h"

#include <cmpg/options.h>

#include <array>
#include <span>
#include <vector>

namespace cmpg {

// A weight in (0, 1] for each pixel of a squared loss: s / (s + v), with v the variance of the image at its neighbours, and s the
// mean variance of all pixels and what is left of the loss (`value`, without noise). Where an image is far noisier than elsewhere, as in light that paths find
// by chance, single pixels would otherwise decide what texels become. v is the squared mean of standard deviations, so that one bright path
// does not take the weight of all that lie about it, and leaves out the pixel itself: a weight that looked at its pixel's noise would prefer pixels
// that are too dark. `halves`: two estimates of the image with noise of their own, as in evaluateLoss(). Empty where all have 1: the image has no noise.
std::vector<float> noiseWeights(Loss loss, const std::array<Image, 2>& halves, const Target& target, double value);
// Of the loss's derivatives by the image.
void weigh(Image& derivatives, std::span<const float> weights);

} // namespace cmpg
