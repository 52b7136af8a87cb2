// The image of an optimisation's view, carried from step to step (recursive control variates: Nicolet, Rousselle, Novak, Keller, Jakob,
// Mueller 2023, "Recursive Control Variates for Inverse Rendering").
#pragma once

#include "optimize/image_model.h"

#include <array>

namespace cmpg {

// F_t = (1 - a) (F_{t-1} + D_t) + a I_t, with I_t an image under the values of step t and D_t its difference to the image under the values of the
// step before along the same paths. Both have the right mean, so F_t has it whatever the weights a, as long as they do not look at the noise of
// I_t and D_t. The variance of D falls with the square of the step of the parameters, so F gathers the samples of many steps without lag.
//
// It consists of two halves with random numbers of their own. How they differ is its variance, and products of both have no bias by noise.
// What remains biased: F and the parameters that it led to are correlated.
struct RunningImage {
    std::array<Image, 2> half;
    std::uint32_t samples = 0; // of each half so far: its next ones continue their sequence
    // Of a half image of one sample per pixel, averaged over the steps so far: variance of I, of D, and their covariance; means over the entries.
    double imageVariance = 0, differenceVariance = 0, covariance = 0;
    std::uint32_t differences = 0; // steps in the averages of the last two

    bool empty() const { return half[0].values.empty(); }
    // The first image, or one that has nothing to do with those before.
    void begin(ImageHalves halves);
    // Those of step t, rendered with `halves.samples` samples each.
    void advance(const ImageHalves& halves);
    Image mean() const;
    double variance() const; // of mean(), averaged over its entries
};

} // namespace cmpg
