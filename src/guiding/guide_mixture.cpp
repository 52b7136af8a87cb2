// The mixture weights of the guide on the host.
#include "guiding/guide_mixture.h"

#include "base/double_shader.h"
#include "shared/guide.h"

namespace cmpg {
namespace {

namespace shader {
using namespace double_shader;
using gpu::kGuidePrimal, gpu::kGuideDifferential, gpu::kGuideUniform, gpu::kGuideConditional, gpu::kDefensiveParts;
#define float double
struct GuideMixture {
#include "lib/guide_mixture.glsl"
};
#undef float
} // namespace shader

std::uint32_t kindOf(Sampling sampling) {
    switch (sampling) {
    case Sampling::Primal:
        return gpu::kGuidePrimal;
    case Sampling::Differential:
        return gpu::kGuideDifferential;
    case Sampling::Uniform:
        return gpu::kGuideUniform;
    case Sampling::Conditional:
    case Sampling::Bsdf:
    case Sampling::Auto:
        break;
    }
    return gpu::kGuideConditional;
}

} // namespace

std::array<double, 3> mixtureOfCameraPath(Sampling sampling, const GuideMass& mean) {
    shader::GuideMixture mixture;
    const glm::dvec3 total(mean.primal, mean.plus, mean.minus);
    const std::uint32_t kind = kindOf(sampling);
    glm::dvec3 weights = mixture.guideWeights(kind, total, 0, 1, 0);
    if (kind == gpu::kGuideConditional)
        weights = mixture.guideDefended(weights, total);
    return {weights.x, weights.y, weights.z};
}

} // namespace cmpg
