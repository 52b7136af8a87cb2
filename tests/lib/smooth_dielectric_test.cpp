// Smooth dielectrics: refraction and reflection of single directions, against known truths; and surfaces that are black from behind.
#include "mitsuba_lobes.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;
using shader_double::kAtBaseColor, shader_double::kAtSpecular;

Library::Surface glass(double ior, std::uint32_t flags = gpu::kMaterialSmooth) {
    return {glm::dvec3(1), 0, 0, 0, glm::dvec3(1), ior, 0, model(gpu::kModelDielectric) | flags};
}

// In front not a bit changes.
TEST(OneSided, BlackFromBehind) {
    Library library;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    const auto numbers = [&] { return glm::dvec3(uniform(random), uniform(random), uniform(random)); };
    int lit = 0;
    for (const std::uint32_t flags : {model(gpu::kModelMetallicRoughness), model(gpu::kModelConductor), model(gpu::kModelConductor) | gpu::kMaterialSmooth,
                                      model(gpu::kModelPlastic) | gpu::kMaterialSmooth})
        for (int i = 0; i < 2000; ++i) {
            const Library::Surface both{numbers(), 0.3 + 0.5 * uniform(random), uniform(random), uniform(random), numbers(), 1.5, ~0u, flags};
            Library::Surface one = both;
            one.model |= gpu::kMaterialOneSided;
            const glm::dvec3 n(0, 0, 1), wo = glm::normalize(numbers() * 2.0 - 1.0), wi = glm::normalize(numbers() * 2.0 - 1.0), u = numbers();
            const bool front = wo.z > 0;
            Library::BsdfDerivatives d, expected;
            const glm::dvec3 value = library.bsdfCosDerivatives(one, n, wo, wi, d), twoSided = library.bsdfCosDerivatives(both, n, wo, wi, expected);
            EXPECT_EQ(value, front ? twoSided : glm::dvec3(0));
            for (std::uint32_t k = 0; k < shader_double::kDerivativePlaces; ++k)
                EXPECT_EQ(d.at[k], front ? expected.at[k] : glm::dvec3(0));
            EXPECT_EQ(library.bsdfPdf(one, n, wo, wi), front ? library.bsdfPdf(both, n, wo, wi) : 0);
            glm::dvec3 drawn, drawnOfBoth;
            double single, singleOfBoth;
            EXPECT_EQ(library.sampleBsdf(one, n, wo, u, drawn, single), front && library.sampleBsdf(both, n, wo, u, drawnOfBoth, singleOfBoth));
            if (front) {
                EXPECT_EQ(drawn, drawnOfBoth);
                EXPECT_EQ(single, singleOfBoth);
            }
            lit += front && value.x > 0;
        }
    EXPECT_GT(lit, 500);
}

// All directions of both sides: where they go, and that nothing is lost but by the scale of radiance.
TEST(SmoothDielectric, ReflectsAndRefracts) {
    Library library;
    const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.5, 0.8));
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    int reflections = 0, refractions = 0, total = 0;
    for (int i = 0; i < 20000; ++i) {
        const double ior = 0.5 + 2 * uniform(random);
        const Library::Surface s = glass(ior);
        const glm::dvec3 wo = glm::normalize(glm::dvec3(uniform(random), uniform(random), uniform(random)) * 2.0 - 1.0);
        const double c = std::abs(glm::dot(n, wo)), eta = glm::dot(n, wo) > 0 ? ior : 1 / ior;
        if (c < 1e-3) continue;
        glm::dvec3 wi;
        double probability;
        ASSERT_TRUE(library.sampleBsdf(s, n, wo, glm::dvec3(uniform(random), uniform(random), uniform(random)), wi, probability));
        ASSERT_GT(probability, 0);
        ASSERT_NEAR(glm::length(wi), 1, 1e-12);
        ASSERT_NEAR(glm::dot(glm::cross(n, wo), wi), 0, 1e-12) << "leaves the plane of incidence";
        EXPECT_EQ(library.bsdfPdf(s, n, wo, wi), 0);
        EXPECT_EQ(library.bsdfCos(s, n, wo, wi), glm::dvec3(0));
        Library::BsdfDerivatives d;
        const glm::dvec3 carried = library.singleCosDerivatives(s, n, wo, wi, d);
        const double f = library.dielectricBoundary(c, eta).reflected;
        if (glm::dot(n, wi) * glm::dot(n, wo) > 0) {
            ++reflections;
            total += f == 1;
            ASSERT_NEAR(glm::dot(n, wi), glm::dot(n, wo), 1e-12);
            ASSERT_NEAR(carried.x, f, 1e-12);
            ASSERT_NEAR(carried.x / probability, 1, 1e-12) << "white glass absorbs nothing";
            ASSERT_NEAR(d.at[kAtSpecular].x, carried.x, 1e-15);
            ASSERT_EQ(d.at[kAtBaseColor].x, 0);
        } else {
            ++refractions;
            ASSERT_NEAR(glm::length(glm::cross(n, wo)), eta * glm::length(glm::cross(n, wi)), 1e-9) << "Snell";
            ASSERT_NEAR(carried.x / probability * eta * eta, 1, 1e-10);
            ASSERT_NEAR(library.radianceScale(s, n, wo, wi), 1 / (eta * eta), 1e-12);
            ASSERT_NEAR(d.at[kAtBaseColor].x, carried.x, 1e-15);
            ASSERT_EQ(d.at[kAtSpecular].x, 0);
        }
    }
    EXPECT_GT(reflections, 1000);
    EXPECT_GT(refractions, 5000);
    EXPECT_GT(total, 500);
}

TEST(SmoothDielectric, BlackPartsAreSampledForTheirDerivativeAlone) {
    Library library;
    Library::Surface s = glass(1.5);
    s.specularColor = glm::dvec3(0);
    const glm::dvec3 n(0, 0, 1), wo = at(0.8);
    glm::dvec3 wi;
    double probability;
    ASSERT_TRUE(library.sampleBsdf(s, n, wo, glm::dvec3(0.5, 0.5, 0), wi, probability));
    EXPECT_EQ(probability, 1);
    EXPECT_LT(wi.z, 0);
    s.asked = 1u << gpu::kSlotSpecular;
    ASSERT_TRUE(library.sampleBsdf(s, n, wo, glm::dvec3(0.5, 0.5, 0), wi, probability));
    EXPECT_GT(wi.z, 0);
    EXPECT_LT(probability, 0.1);
    s.asked = 0;
    s.baseColor = glm::dvec3(0);
    EXPECT_FALSE(library.sampleBsdf(s, n, wo, glm::dvec3(0.5, 0.5, 0.9), wi, probability));
}

// The interpolated normal of a coarse mesh at its silhouette: nothing may end on the wrong side of the face.
TEST(SmoothDielectric, NormalsThatCrossTheFaceAreReplaced) {
    Library library;
    const Library::Surface s = glass(1.5);
    const glm::dvec3 face(0, 0, 1);
    int replaced = 0;
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < 20000; ++i) {
        const glm::dvec3 normal = glm::normalize(glm::dvec3(0.6 * uniform(random), 0.6 * uniform(random), i % 2 ? 1 : -1));
        const glm::dvec3 wo = glm::normalize(glm::dvec3(uniform(random), uniform(random), uniform(random)));
        if (std::abs(wo.z) < 1e-3) continue;
        const glm::dvec3 n = library.boundaryNormal(s, normal, face, wo);
        replaced += n == face;
        EXPECT_GT(glm::dot(n, wo) * wo.z, 0);
        for (const double u : {0.0, 0.999999}) {
            glm::dvec3 wi;
            double probability;
            if (!library.sampleBsdf(s, n, wo, glm::dvec3(0.5, 0.5, u), wi, probability)) continue;
            EXPECT_EQ(glm::dot(n, wi) * glm::dot(n, wo) > 0, wi.z * wo.z > 0);
        }
    }
    EXPECT_GT(replaced, 500);
    EXPECT_LT(replaced, 10000);
}

} // namespace
} // namespace cmpg::test
