// Which texels of a parameter a surface point reads.
#include "scene/texel_lookup.h"

#include "base/double_shader.h"

namespace cmpg {
namespace {

namespace shader {
using namespace double_shader;
#define float double
struct Texels {
#include "lib/texel.glsl"
};
#undef float
} // namespace shader

} // namespace

TexelLookup lookUp(const Parameter& parameter, const glm::vec2& uv0, const glm::vec2& uv1) {
    const glm::vec2 uv = parameter.uvTransform * glm::vec3(parameter.texcoord == 1 ? uv1 : uv0, 1);
    const auto found = shader::Texels().texelWeights(uv, parameter.width, parameter.height, std::uint32_t(parameter.wrapU), std::uint32_t(parameter.wrapV), parameter.nearest);
    TexelLookup result{};
    for (int k = 0; k < 4; ++k) {
        result.texel[std::size_t(k)] = found.index[k];
        result.weight[std::size_t(k)] = float(found.weight[k]);
    }
    return result;
}

} // namespace cmpg
