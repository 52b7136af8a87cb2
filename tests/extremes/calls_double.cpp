// The double-precision half of calls.h.
#include "lib/shader_double.h"

#include "calls.h"

cmpg::test::Numbers cmpg::test::callDouble(Function function, const std::vector<float>& arguments) {
    using shader_double::ShaderLibrary;
    using Real = double;
    using Vec2 = glm::dvec2;
    using Vec3 = glm::dvec3;
#include "calls.inc"
}

cmpg::test::GuideDraw cmpg::test::followDouble(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec2& u) {
    shader_double::ShaderLibrary library;
    library.guideSpatial = table.spatial;
    library.guideMasses.assign(table.masses.begin(), table.masses.end());
    library.guideChildren = table.children;
    const glm::dvec3 total(table.cells[cell].total);
    const glm::dvec3 weights = library.guideWeights(mixture.kind, total, mixture.light, mixture.derivative, mixture.sign);
    const auto score = glm::dot(weights, total);
    GuideDraw draw{weights, double(score), {}, 0, 0, 0};
    if (!(score > library.kMinGuideScore)) return draw;
    const std::uint32_t root = table.cells[cell].root;
    const auto walk = library.guideWalk(root, weights, score, false, glm::dvec2(u));
    draw.point = walk.point;
    draw.density = double(walk.density);
    draw.leaf = walk.leaf;
    draw.again = double(library.guideDensity(root, weights, score, walk.point));
    return draw;
}
