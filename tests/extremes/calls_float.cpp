// The single-precision half of calls.h.
#include "lib/shader_float.h"

#include "calls.h"

cmpg::test::Numbers cmpg::test::callFloat(Function function, const std::vector<float>& arguments) {
    using shader_float::ShaderLibrary;
    using Real = float;
    using Vec2 = glm::vec2;
    using Vec3 = glm::vec3;
#include "calls.inc"
}

cmpg::test::GuideDraw cmpg::test::drawFloat(const GuideTable& table, std::uint32_t cell, const Mixture& mixture, const glm::vec2& u) {
    shader_float::ShaderLibrary library;
    library.guideSpatial = table.spatial;
    library.guideMasses = table.masses;
    library.guideChildren = table.children;
    const glm::vec3 total(table.cells[cell].total);
    const glm::vec3 weights = library.guideWeights(mixture.kind, total, mixture.light, mixture.derivative, mixture.sign);
    const auto score = glm::dot(weights, total);
    GuideDraw draw{weights, double(score), {}, 0, 0, 0};
    if (!(score > library.kMinGuideScore)) return draw;
    const std::uint32_t root = table.cells[cell].root;
    const auto walk = library.guideWalk(root, weights, score, true, glm::vec2(u));
    draw.point = walk.point;
    draw.density = double(walk.density);
    draw.leaf = walk.leaf;
    draw.again = double(library.guideDensity(root, weights, score, walk.point));
    return draw;
}

cmpg::test::Drawn cmpg::test::sampleFloat(const Query& q, const std::array<float, 3>& u) {
    shader_float::ShaderLibrary library;
    using Vec3 = glm::vec3;
    const shader_float::ShaderLibrary::Surface surface{Vec3(q.baseColor), q.roughness, q.metallic, q.specular, Vec3(q.specularColor), q.ior};
    const Vec3 n(q.normal), wo(q.wo);
    Vec3 wi;
    Drawn drawn{library.sampleBsdf(surface, n, wo, Vec3(u[0], u[1], u[2]), wi), glm::vec3(0), 0, glm::dvec3(0)};
    drawn.wi = glm::vec3(wi);
    if (!drawn.any) return drawn;
    const auto density = library.bsdfPdf(surface, n, wo, wi);
    drawn.density = double(density);
    drawn.weight = library.bsdfCos(surface, n, wo, wi) / density;
    return drawn;
}
