// The single-precision half of evaluate.h.
#include "shader_float.h"

#include "evaluate.h"

cmpg::test::Evaluation cmpg::test::evaluateFloat(const Query& query) {
    using Real = float;
    using namespace shader_float;
#include "evaluate.inc"
}

bool cmpg::test::sampleFloat(const Query& q, const glm::vec3& u, glm::vec3& wi) {
    float single;
    return sampleFloat(q, u, wi, single);
}

bool cmpg::test::sampleFloat(const Query& q, const glm::vec3& u, glm::vec3& wi, float& single) {
    shader_float::ShaderLibrary library;
    const shader_float::ShaderLibrary::Surface surface{q.baseColor, q.roughness, q.metallic, q.specular, q.specularColor, q.ior, ~0u, q.model,
                                                       {q.clearcoat, q.clearcoatRoughness, q.anisotropy, q.sheenRoughness}, q.tangent, q.sheenColor, q.coatNormal};
    return library.sampleBsdf(surface, q.normal, q.wo, u, wi, single);
}
