// Total variation of a texture.
#pragma once

#include "optimize/coarse_texture.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace cmpg {

// What a difference of neighbours costs, f(d) with d the root mean square over the channels: with r = sqrt(d^2 + epsilon^2), so that the gradient is smooth at
// 0, r - epsilon; where `unit` is not 0 less for large ones, unit^(1/4) (r^(3/4) - epsilon^(3/4)).
struct DifferenceCost {
    double epsilon, unit = 0;
};
constexpr DifferenceCost kTotalVariation{1e-3}; // a quarter of an 8-bit step
// Of the prior, for slots from 0 to 1. Edges are few and steep: of differences that add up to as much, one costs less than many. The width keeps steps of an
// optimiser from chattering about 0.
constexpr DifferenceCost kPriorCost{1e-2, 0.25};

// By how much neighbours are expected to differ: to the right and below, entries() each; none where they are expected to be alike.
struct ExpectedDifferences {
    std::vector<float> right, below;
    bool empty() const { return right.empty(); }
};
// Those of a guess (guessTexture), but for neighbours that are both seen.
ExpectedDifferences expectedDifferences(const TextureGrid& grid, std::span<const float> guess, const std::vector<bool>& seen);

TextureGrid gridOf(const Parameter& parameter);

// Returns weight * TV and adds its gradient. TV is the sum over pairs of horizontal and vertical neighbours of n f(d), with n channels and d^2 the mean square
// of how their differences differ from expected ones, divided by the number of entries. The channels share a root, so
// that their edges fall together (Blomgren and Chan, Color TV, 1998). Neighbours across an edge count where the texture repeats; an
// environment wraps around horizontally. 0 for constants. `strengths`: by texel; a pair counts by the less of its two. Empty: all 1.
double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, const DifferenceCost& cost = kTotalVariation,
                         const ExpectedDifferences& expected = {}, std::span<const float> strengths = {});

// The quadratic form that touches weighted total variations from above at the current values: f is concave in d^2 + epsilon^2, so that its tangent at the
// difference now bounds it (half-quadratic minimisation: Geman and Yang 1995). Its matrix L has the weights of pairs off its diagonal, negative, and their
// sums on it.
class TotalVariationBound {
  public:
    explicit TotalVariationBound(const Parameter& parameter);
    void add(const Parameter& parameter, double weight, const DifferenceCost& cost, const ExpectedDifferences& expected = {},
             std::span<const float> strengths = {}); // of the same shape
    bool empty() const { return right_.empty(); }                        // L = 0
    const TextureGrid& grid() const { return grid_; }
    // About P^T L P: a coarse pair has the weights of the fine ones between its two texels, times the squared share of its difference that is across each.
    TotalVariationBound coarser(const CoarseTexture& texture) const;
    // out = own + the diagonal of L; out = (diagonal matrix `own` + L) x. entries() each.
    void diagonal(std::span<const float> own, std::span<float> out) const;
    void multiply(std::span<const float> own, std::span<const float> x, std::span<float> out) const;

  private:
    explicit TotalVariationBound(const TextureGrid& grid) : grid_(grid) {}
    // Of each entry of a row and its neighbours.
    struct Weights {
        const float *right, *left, *below, *above;
    };
    // Calls row(first entry, weights) for every row.
    template <class Row> void forRows(const Row& row) const;

    TextureGrid grid_;
    std::vector<float> right_, below_; // weights of the pairs of a texel and the one to its right, and below; 0 where there is none
};

} // namespace cmpg
