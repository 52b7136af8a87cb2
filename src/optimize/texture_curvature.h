// D + L of a texture, or D + C + L, and steps by it.
#pragma once

#include "optimize/regularizer.h"
#include "optimize/seen_texels.h"

#include <span>
#include <vector>

namespace cmpg {

// Of what cameras see directly, `part` of its curvature is known texel by texel. Null: nothing is.
struct SeenPart {
    const SeenTexels* texels = nullptr;
    float part = 0;
};

// A diagonal that bounds the curvature of the loss, D, and the curvature of what is known of the texture, L. Where cameras see texels, what D has of these is
// C instead: D then is the rest, without the sums of C's rows. `known` and `seen` outlive it.
class TextureCurvature {
  public:
    // D is `measured` and a thousandth of its mean, and at least `deviation` / `stray`: the noise of a gradient takes no entry farther than `stray`. A
    // quarter of that is left beside C.
    TextureCurvature(const TotalVariationBound& known, const SeenPart& seen, std::span<const float> measured, std::vector<float> deviation, float stray);
    // g^T diag(D + C + L)^-1 g
    double length(std::span<const float> gradient) const;
    // (D + C + L)^-1 g, by conjugate gradients with the diagonal as the preconditioner. 0 for entries that nothing depends on.
    std::vector<float> solve(std::vector<float> gradient) const;

  private:
    void multiply(std::span<const float> x, std::span<float> out) const; // out = (D + C + L) x

    const TotalVariationBound& known_;
    SeenPart seen_;
    std::vector<float> own_;     // D
    std::vector<float> inverse_; // of the diagonal of D + C + L
};

} // namespace cmpg
