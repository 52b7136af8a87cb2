// Gauss-Newton steps: a diagonal that bounds the curvature of the loss, the exact curvature of what is known of textures, and steps as long as
// the noise of the gradient allows, of many texels together before those of single ones.
#pragma once

#include "optimize/optimizer.h"
#include "optimize/regularizer.h"

#include <algorithm>
#include <limits>
#include <span>

namespace cmpg {

// The squared loss has the Hessian H = 2/n J^T W J, with J the derivative of the image, where the image is nearly linear in the parameter. For H without
// negative entries and any positive vector d, the diagonal (H d)_i / d_i bounds H from above: steps of (D + L)^-1 g descend, with L the
// bound of the total variation (TotalVariationBound). One image difference along d and one derivative pass of it give H d.
//
// d by entries: the same for all, or, of light, its values. D is then smaller the brighter an entry is. With equal d, where all entries light the same
// pixels, the many dark ones would hold back a bright one.
struct CurvatureDirection {
    float step;                     // of all entries
    std::span<const float> light{}; // values of light
    float share = 0;                // of them that is moved
    float operator[](std::size_t entry) const {
        constexpr float kDark = 0.1f; // what is darker than this part of the unit moves as if it had so much
        return light.empty() ? step : std::max(kDark * step, share * light[entry]);
    }
};

// Adds what such a product told: `product` = H d. Moments::second is D. The second and later products count by half; of light the last one counts
// alone, since earlier ones were of other values.
void addCurvature(std::span<const double> product, const CurvatureDirection& direction, Moments& moments);
// Where steps do not see all views, each has its `part` of the mean over all, added up over steps, and the `largest` of its views. `share`: of the views
// that it saw, of all, where they were measured before; 0 where they were not.
void addCurvature(std::span<const double> part, std::span<const double> largest, const CurvatureDirection& direction, double share, Moments& moments);

// The gradient of a step. All have entries() entries.
struct NoisyGradient {
    std::span<const double> mean; // of the whole objective
    std::vector<double> half;     // half of how two independent halves of it differ: its variance is the mean's
    double viewShare = 1;         // of the views that it is of, of all
};

// One update of parameter.values, projected to its range: x += v, v = momentum v - u, with |v| at most `rate` times kNewtonReach, and 0.04 of a lobe's shape or a normal.
// u is the sum of steps on ever finer grids, from one texel for all to the texture itself (CoarseTexture): each is s P (D + L)^-1 r, with r what the
// coarser ones leave of the gradient, P^T g - (D + L) u, where D, L and u are the grid's own. Where g is of some of the views, D bounds whichever views these may be: so an entry that one view alone
// sees goes no farther when its turn comes than it would with all, and v has no momentum. Nor has it where a quarter of the gradient by a lobe's
// shape is noise. s is the share of the signal in the squared length of P^T g, measured by the diagonal of (D + L)^-1, on average over steps: of a gradient that is
// all noise next to nothing is followed, and steps of a noisy one average like 1/t. Noise cancels where a coarse texel adds up many, so what they have in
// common arrives long before a texel's own value. An entry whose noise, of the last steps or of this one, would take it farther than `rate` has a larger D:
// what few paths reach, and paths that are rare. Where L is 0 there is the texture's grid alone. On that grid, C stands for what D has of the texels that
// cameras see (SeenTexels), by the square of s: a diagonal takes many steps to tell texels apart that a pixel sees at once, and averages noise over them,
// which C's inverse would follow. Entries whose gradient is not finite do not move by it; returns how many. `lightUnit`: of light, what its values are
// measured by; the rate of an entry that is brighter grows as its value does. 0: no light. `coarse`: from the texture to the grid that stands for it where its
// texels are finer than images tell: the last step is on that one, SeenTexels are of it, and what the values have within its texels stays. Null: its own.
std::uint64_t updateByGaussNewton(double rate, NoisyGradient gradient, const TotalVariationBound& known, Moments& moments,
                                  Parameter& parameter, double lightUnit = 0, const CoarseTexture* coarse = nullptr);

// Images are far from linear in the shape of lobes and in normals, and their highlights, the noisiest pixels, tell most of these.
inline bool isFarFromLinear(SlotKind kind) { return shapesLobe(kind) || kind == SlotKind::Normal; }

// The share of the signal, from 0 to 1; 1 before anything was measured.
double signalShare(const SignalNoise& noise);

constexpr double kNewtonReach = 10; // times the rate: the largest step of an entry

// For updates of one map and of several together.
constexpr double kLatestWeight = 0.3; // of the latest step in averages over steps
// Finite, and its square as well.
inline bool isUsable(float value) { return value * value <= std::numeric_limits<float>::max(); }
inline float usableOrZero(double entry) { return isUsable(float(entry)) ? float(entry) : 0.f; }
double reachOf(SlotKind kind, double rate); // how far an entry may go in a step
// With the texture's own: of one, where nothing connects texels, since those that no path met would move with the others.
std::size_t countOfGrids(const TotalVariationBound& known);
// Adds `half` to the averages of SignalNoise::squares; returns the deviations, of this step or of the last ones, whichever are larger.
std::vector<float> followNoise(std::vector<float>& squares, std::span<const float> half, float weight);

} // namespace cmpg
