// The double-precision half of calls.h.
#include "lib/shader_double.h"

#include "calls.h"

namespace cmpg::test {
namespace {
using shader_double::ShaderLibrary;
using Real = double;
using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
#include "calls.inc"
} // namespace

Numbers callDouble(Function function, const std::vector<float>& arguments) { return call(function, arguments); }

GuideDraw followDouble(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec2& at) {
    return walk(table, cell, mixture, false, glm::vec3(at, 0));
}

Drawn sampleDouble(const Query& query, const std::array<float, 3>& u) { return sample(query, u); }

} // namespace cmpg::test
