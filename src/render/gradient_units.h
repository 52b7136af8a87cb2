// Units of the gradient sums of a pass. Sums are integers, so that no order of execution shows in them.
#pragma once

#include "scene/scene.h"

#include <span>

namespace cmpg {

// What did not go into the gradient sums of a pass.
struct Unsummed {
    std::uint32_t tooLarge = 0; // contributions
    bool tooSmall = false;      // some were less than half a unit
};

// Length of the shortest vector of the differentiable normals, by whose inverse their derivatives grow; at most 1, and not so short
// that a few texels near zero cost the others' accuracy.
double shortestNormal(const Scene& scene, std::span<const std::uint32_t> differentiable);

// Units follow from what a pass is expected to sum up. The expectation can be far too small: a black scene has derivatives and no radiance.
// Then units get coarser until sums fit, and the pass is repeated. Or it is far too large: what is bright need not depend on a parameter. Then
// units get finer, unless sums are small because large contributions cancel, which the finer unit cannot hold. Never both, and the choice
// depends on the pass alone.
class GradientUnits {
  public:
    // `adjointSum`: over the pixels of mean_rgb |adjoint|; `radiance`: mean of the view; `shortest`: see shortestNormal().
    GradientUnits(double adjointSum, double radiance, double shortest);

    // Factors that turn a contribution into units: 2^k in two floats.
    glm::vec2 surfaceScale() const { return surface_.scale; }
    glm::vec2 normalScale() const { return normal_.scale; }
    glm::vec2 emissionScale() const { return emission_.scale; }
    double unitOf(SlotKind kind) const;

    // Chooses other units after a pass where these did not suit; false where they stay. `resolved()`: whether sums are large enough that
    // rounding does not show; it is asked only where the answer matters.
    template <class Resolved> bool change(const Unsummed& unsummed, Resolved&& resolved) {
        if (unsummed.tooLarge > 0 && finer_ > 0) {
            cancelled_ = true;
            --finer_;
        } else if (unsummed.tooLarge > 0 && coarser_ < kCoarsenings) {
            ++coarser_;
        } else if (unsummed.tooLarge == 0 && coarser_ == 0 && finer_ < kRefinements && !cancelled_ && !resolved()) {
            ++finer_;
        } else {
            return false;
        }
        choose();
        return true;
    }

  private:
    static constexpr int kCoarsenings = 3; // at most: what is larger still has overflowed as a float
    static constexpr int kRefinements = 2; // at most: a second one for what the first unit rounded to nothing
    struct Unit {
        glm::vec2 scale{1};
        double unit = 1;
    };
    void choose();

    double adjointSum_, radiance_, normalGrowth_;
    int coarser_ = 0, finer_ = 0;
    bool cancelled_ = false;
    Unit surface_, normal_, emission_;
};

} // namespace cmpg
