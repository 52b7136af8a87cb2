// How much nearer images come to their targets where the shape of a lobe takes another value.
#pragma once

#include "optimize/image_model.h"
#include "optimize/target.h"

#include <array>

namespace cmpg {

// By how much a squared loss falls, summed over views; a mean of rounds.
class ShapeGain {
  public:
    // Images of a view, twice and with random numbers of their own, each time by the same ones for both values: what the shape does not change has no
    // part in this. `weight`: lossCurvature().
    void add(const std::array<ImageHalves, 2>& now, const std::array<ImageHalves, 2>& tried, const Target& target, const Image& weight);
    void endRound() { ++rounds_; } // all views are added

    double mean() const { return sum_ / rounds_; }
    double error() const; // standard error of the mean, by how the two differ pixel by pixel

  private:
    double sum_ = 0, variance_ = 0, rounds_ = 0;
};

} // namespace cmpg
