// D + L of a texture, and steps by it.
#pragma once

#include "optimize/regularizer.h"

#include <span>
#include <vector>

namespace cmpg {

// A diagonal that bounds the curvature of the loss, D, and the curvature of what is known of the texture, L. `known` outlives it.
class TextureCurvature {
  public:
    // D is `measured`, at least a thousandth of its mean, and at least `deviation` / `stray`: the noise of a gradient takes no entry farther than `stray`.
    TextureCurvature(const TotalVariationBound& known, std::span<const float> measured, std::vector<float> deviation, float stray);
    // g^T diag(D + L)^-1 g
    double length(std::span<const float> gradient) const;
    // (D + L)^-1 g, by conjugate gradients with the diagonal as the preconditioner. 0 for entries that nothing depends on.
    std::vector<float> solve(std::vector<float> gradient) const;

  private:
    const TotalVariationBound& known_;
    std::vector<float> own_;     // D
    std::vector<float> inverse_; // of the diagonal of D + L
};

} // namespace cmpg
