// One material evaluation by the float and by the double build of the shader library, in common types.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <random>

namespace cmpg::test {

// In float, so that both builds see the same input.
struct Query {
    glm::vec3 baseColor{0.5f};
    float roughness = 0.5f, metallic = 0, specular = 1;
    glm::vec3 specularColor{1};
    float ior = 1.5f;
    std::uint32_t model = 0; // GpuMaterial::flags
    glm::vec3 normal{0, 0, 1}, wo{0, 0, 1}, wi{0, 0, 1};
    float clearcoat = 0, clearcoatRoughness = 0; // where the model has their bits
    float anisotropy = 0; // where the model has its bit
    glm::vec3 tangent{1, 0, 0};
    float sheenRoughness = 0; // where the model has its bit
    glm::vec3 sheenColor{0};
    glm::vec3 coatNormal{0}; // zero: the coat's is `normal`
};

struct Evaluation {
    glm::dvec3 value;
    double pdf;
    glm::dvec3 baseColor, roughness, metallic, specular; // derivatives
    glm::dmat3 normal;                                   // column: colour channel; row: component of the normal
    glm::dvec3 clearcoat{0}, clearcoatRoughness{0}, anisotropy{0};
    glm::dvec3 sheenRoughness{0};
    glm::dmat3 sheenColor{0}; // column: colour channel; row: component of the slot
};

Evaluation evaluateFloat(const Query& query);
Evaluation evaluateDouble(const Query& query);

// A direction drawn by the float build; false: none.
bool sampleFloat(const Query& query, const glm::vec3& u, glm::vec3& wi);
// `single`: the probability of a single direction, 0 for one drawn with the density.
bool sampleFloat(const Query& query, const glm::vec3& u, glm::vec3& wi, float& single);

// Random queries: roughness 0 to 1 (many at and near the floor), grazing directions down to `minCosine`, half vectors within and far
// outside the lobe, black and white colours, all mixes of lobes, both sides of the normal.
class QueryGenerator {
  public:
    QueryGenerator(std::uint32_t seed, double minCosine) : random_(seed), minCosine_(minCosine) {}
    Query operator()();

  private:
    double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
    double unitOrEdge(); // in [0,1], often exactly 0 or 1
    glm::dvec3 direction();
    double cosine();

    std::mt19937 random_;
    double minCosine_;
};

} // namespace cmpg::test
