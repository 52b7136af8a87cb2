// The single-precision half of calls.h.
#include "lib/shader_float.h"

#include "calls.h"

namespace cmpg::test {
namespace {
using shader_float::ShaderLibrary;
using Real = float;
using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
#include "calls.inc"
} // namespace

Numbers callFloat(Function function, const std::vector<float>& arguments) { return call(function, arguments); }

GuideDraw drawFloat(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec3& u) {
    return walk(table, cell, mixture, true, u);
}

Drawn sampleFloat(const Query& query, const std::array<float, 3>& u) { return sample(query, u); }

} // namespace cmpg::test
