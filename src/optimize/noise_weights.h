// Weights of pixels by the noise of the image around them.
#pragma once

#include "optimize/target.h"

#include <cmpg/options.h>

#include <array>
#include <span>
#include <vector>

namespace cmpg {

// How noisy an image is, in the unit of a squared loss.
struct ImageNoise {
    // By pixel, the variance of the image at its neighbours: the squared mean of standard deviations, so that one bright path does not stand for all that lies
    // about it. It leaves out the pixel itself: what looked at its pixel's noise would prefer pixels that are too dark. 0 where there are no neighbours.
    std::vector<float> around;
    double mean = 0; // of the variance of all pixels
};
// `halves`: two estimates of the image with noise of their own, as in evaluateLoss(). Pixels without weight in the target are left out.
ImageNoise noiseOf(Loss loss, const std::array<Image, 2>& halves, const Target& target);

// A weight in (0, 1] for each pixel of a squared loss: s / (s + v), with v the noise around it, and s the mean noise and what is left of the loss (`value`,
// without noise). Where an image is far noisier than elsewhere, as in light that paths find by chance, single pixels would otherwise decide what
// texels become. Empty where all have 1: the image has no noise.
std::vector<float> noiseWeights(Loss loss, const std::array<Image, 2>& halves, const Target& target, double value);
// Of the loss's derivatives by the image.
void weigh(Image& derivatives, std::span<const float> weights);

} // namespace cmpg
