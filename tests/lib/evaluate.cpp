// The double-precision half of evaluate.h, and its random queries.
#include "evaluate.h"

#include "shader_double.h"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace cmpg::test {

Evaluation evaluateDouble(const Query& query) {
    using Real = double;
    using namespace shader_double;
#include "evaluate.inc"
}

double QueryGenerator::unitOrEdge() {
    const double u = uniform();
    return u < 0.2 ? 0 : u < 0.4 ? 1 : uniform();
}

// |z| is log-uniform in [minCosine, 1]; about z.
double QueryGenerator::cosine() { return uniform() < 0.3 ? uniform() : std::pow(minCosine_, uniform()); }

glm::dvec3 QueryGenerator::direction() {
    const double z = std::max(cosine(), minCosine_), phi = 2 * glm::pi<double>() * uniform(), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
}

Query QueryGenerator::operator()() {
    Query q;
    for (int c = 0; c < 3; ++c) {
        q.baseColor[c] = float(unitOrEdge());
        q.specularColor[c] = float(uniform() < 0.3 ? 2 * uniform() : 1);
    }
    q.metallic = float(unitOrEdge());
    q.specular = float(unitOrEdge());
    q.ior = float(uniform() < 0.5 ? 1.5 : 1 + 2 * uniform());
    const double u = uniform();
    q.roughness = float(u < 0.2 ? 0 : u < 0.4 ? 1 : u < 0.6 ? std::pow(10, -3 * uniform()) : uniform());

    // Around the mirror direction at a distance comparable to the lobe's width, or anywhere.
    const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3);
    glm::dvec3 wo = direction(), wi = direction();
    if (uniform() < 0.7) {
        const double tangent = alpha * std::pow(10, 4 * uniform() - 2), phi = 2 * glm::pi<double>() * uniform();
        const glm::dvec3 h = glm::normalize(glm::dvec3(tangent * std::cos(phi), tangent * std::sin(phi), 1));
        const glm::dvec3 mirrored = 2 * glm::dot(h, wo) * h - wo;
        if (mirrored.z > minCosine_) wi = mirrored;
    }
    const double z = 2 * uniform() - 1, phi = 2 * glm::pi<double>() * uniform(), r = std::sqrt(1 - z * z);
    const glm::dvec3 n(r * std::cos(phi), r * std::sin(phi), z);
    const glm::dvec3 x = glm::normalize(glm::cross(n, std::abs(z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
    const glm::dmat3 frame(x, glm::cross(n, x), n);
    q.normal = uniform() < 0.5 ? n : -n; // both sides reflect
    q.wo = frame * wo;
    q.wi = frame * wi;

    return q;
}

} // namespace cmpg::test
