// The image of an optimisation's view, carried from step to step (recursive control variates: Nicolet, Rousselle, Novak, Keller, Jakob,
// Mueller 2023, "Recursive Control Variates for Inverse Rendering").
#pragma once

#include "optimize/image_model.h"

#include <array>

namespace cmpg {

// F_t = (1 - a) (F_{t-1} + D_t) + a I_t, with I_t an image under the values of step t and D_t its difference to the image under the values of the
// step before along the same paths. Both have the right mean, so F_t has it whatever the weights a of its pixels, as long as they do not look at the
// noise of I_t and D_t. The variance of D falls with the square of the step of the parameters, so F gathers the samples of many steps without lag.
//
// It consists of two halves with random numbers of their own. How they differ is its variance, and products of both have no bias by noise.
// What remains biased: F and the parameters that it led to are correlated.
struct RunningImage {
    std::array<Image, 2> half;
    std::uint32_t used = 0;             // samples of a half so far, of the pixel with most, those of dropped images included
    std::vector<std::uint32_t> samples; // by pixel: the next ones continue its own sequence, whose points fill each other's gaps
    std::uint64_t paths = 0;   // of both halves in the last step
    std::vector<float> worth;  // by pixel: samples whose mean has the variance of a half, drawn by `method`
    Sampling method = Sampling::Bsdf;
    // In units of the variance of I, of a sample each, averaged over the steps so far: the variance of D for a change of the parameters of mean square
    // 1, and its covariance with I for one of 1.
    double differenceVariance = 4, covariance = 0;
    std::uint32_t differences = 0; // steps in these averages

    bool empty() const { return half[0].values.empty(); }
    // Of an image of so many pixels, with the shares of its samples (OptimizeState::pixelShares).
    static std::size_t bytes(std::size_t pixels) { return pixels * (2 * 3 + 1 + 1 + 1) * sizeof(float); }
    // The first image, or the first after drop(), with random numbers that follow those of the images before.
    void begin(ImageHalves halves, Sampling drawnBy = Sampling::Bsdf);
    void drop(); // of memory
    // Those of step t are drawn by another method, whose samples have `ratio` times the variance of those so far. Known from earlier steps, as weights must
    // not look at the noise of step t.
    void changeMethod(Sampling to, double ratio);
    // Those of step t. `shares`: by pixel, how much it matters in the averages; empty: all alike. `change`: mean square of how far the parameters went.
    void advance(const ImageHalves& halves, std::span<const float> shares, double change);
    Image mean() const;

  private:
    void count(const ImageHalves& halves, std::size_t pixels);
};

} // namespace cmpg
