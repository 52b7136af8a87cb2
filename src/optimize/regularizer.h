// Total variation of a texture.
#pragma once

#include "optimize/coarse_texture.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace cmpg {

// Differences well below this count quadratically, so that the gradient is smooth at 0: a quarter of an 8-bit step.
constexpr double kTotalVariationEpsilon = 1e-3;
// The same of the prior: wide enough that steps of an optimiser do not chatter about 0.
constexpr double kPriorEpsilon = 1e-2;

// Returns weight * TV and adds its gradient. TV is the sum over pairs of horizontal and vertical neighbours of
// n (sqrt(d^2 + eps^2) - eps), with n channels and d^2 the mean square of their differences, divided by the number of entries. The channels share a root, so
// that their edges fall together (Blomgren and Chan, Color TV, 1998). Neighbours across an edge count where the texture repeats; an
// environment wraps around horizontally. 0 for constants.
double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, double epsilon = kTotalVariationEpsilon);

// The quadratic form that touches weighted total variations from above at the current values: sqrt(d^2 + eps^2) is at most
// (d^2 + eps^2 + s^2) / (2 s), with s that root at the difference now (half-quadratic minimisation: Geman and Yang 1995). Its matrix L has the
// weights of pairs off its diagonal, negative, and their sums on it.
class TotalVariationBound {
  public:
    explicit TotalVariationBound(const Parameter& parameter);
    void add(const Parameter& parameter, double weight, double epsilon); // of the same shape
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
