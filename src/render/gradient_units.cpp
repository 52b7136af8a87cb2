// Units of the gradient sums of a pass.
#include "render/gradient_units.h"

#include "render/integer_scale.h"

#include <cmath>

namespace cmpg {
namespace {

constexpr double kGradientBits = 48; // unit = 2^-48 of the pass's expected sum of magnitudes; 2^14 of headroom above it
constexpr int kCoarsening = 16;      // bits the units lose when the headroom was too little
constexpr int kRefinement = 28;      // bits the units gain when rounding shows: the largest sum then has at most 2^48, what the unit was made for

} // namespace

double shortestNormal(const Scene& scene, std::span<const std::uint32_t> differentiable) {
    double shortest2 = 1;
    for (const std::uint32_t i : differentiable) {
        const Parameter& p = scene.parameters[i];
        if (p.kind == SlotKind::Normal)
            for (std::size_t k = 0; k + 2 < p.values.size(); k += 3) {
                const glm::dvec3 t(p.values[k], p.values[k + 1], p.values[k + 2]);
                shortest2 = std::min(shortest2, glm::dot(t, t));
            }
    }
    return std::max(std::sqrt(shortest2), 0x1p-10);
}

GradientUnits::GradientUnits(double adjointSum, double radiance, double shortest)
    : adjointSum_(adjointSum), radiance_(radiance), normalGrowth_(1 / shortest) {
    choose();
}

void GradientUnits::choose() {
    const double expected = std::ldexp(adjointSum_, kCoarsening * coarser_ - kRefinement * finer_);
    surface_.scale = fixedPointScale(expected * radiance_, kGradientBits, surface_.unit);
    normal_.scale = fixedPointScale(expected * radiance_ * normalGrowth_, kGradientBits, normal_.unit);
    emission_.scale = fixedPointScale(expected, kGradientBits, emission_.unit);
}

double GradientUnits::unitOf(SlotKind kind) const {
    return emitsLight(kind) ? emission_.unit : kind == SlotKind::Normal ? normal_.unit : surface_.unit;
}

} // namespace cmpg
