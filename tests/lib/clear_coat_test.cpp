// The clear coat: its formula in double precision, derivatives, sampling, energy.
#include "evaluate.h"

#include "drawn_directions.h"
#include "surface_differences.h"

#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <numeric>

namespace cmpg::test {
namespace {

using shader_double::kAtBaseColor, shader_double::kAtClearcoat, shader_double::kAtClearcoatRoughness;
using Library = shader_double::ShaderLibrary;
constexpr std::uint32_t kCoated = 1u << gpu::kSlotClearcoat | 1u << gpu::kSlotClearcoatRoughness;

struct CoatedQueries {
    QueryGenerator base;
    std::mt19937 random{41};
    Query operator()() {
        Query q = base();
        std::uniform_real_distribution<float> uniform(0, 1);
        q.clearcoat = random() % 8 == 0 ? 1 : uniform(random);
        q.clearcoatRoughness = random() % 8 == 0 ? 0 : uniform(random);
        q.model |= kCoated;
        return q;
    }
};

Query uncoated(Query q) {
    q.model &= ~kCoated;
    return q;
}

Library::Surface surfaceOf(const Query& q) {
    return {glm::dvec3(q.baseColor), q.roughness, q.metallic, q.specular, glm::dvec3(q.specularColor), q.ior, ~0u, q.model, {q.clearcoat, q.clearcoatRoughness}};
}

// f |cos| with directions that are unit vectors in double precision.
glm::dvec3 valueOf(const Query& q) {
    Library library;
    return library.bsdfCos(surfaceOf(q), glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo)), glm::normalize(glm::dvec3(q.wi)));
}

// README of KHR_materials_clearcoat: f (1 - blend) + coat blend, blend = factor * Schlick(0.04, n.wo), the coat's specular term as that of the base; times |cos|.
glm::dvec3 textbook(const Query& q) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
    const double no = std::abs(glm::dot(n, wo)), ni = std::abs(glm::dot(n, wi));
    if (glm::dot(n, wo) * glm::dot(n, wi) <= 0)
        return glm::dvec3(0);
    const double blend = q.clearcoat * (0.04 + (1 - 0.04) * std::pow(1 - no, 5));
    const double a2 = std::pow(std::max(double(q.clearcoatRoughness) * q.clearcoatRoughness, 1e-3), 2), nh = glm::dot(n, glm::normalize(wo + wi));
    const double distribution = a2 / (glm::pi<double>() * std::pow(nh * nh * (a2 - 1) + 1, 2));
    const auto masking = [&](double c) { return 2 * c / (c + std::sqrt(a2 + (1 - a2) * c * c)); };
    const double coat = distribution * masking(no) * masking(ni) / (4 * no);
    return valueOf(uncoated(q)) * (1 - blend) + glm::dvec3(coat * blend);
}

TEST(ClearCoat, IsWhatTheExtensionSays) {
    CoatedQueries generate{QueryGenerator(31, 0.05)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 found = valueOf(q), expected = textbook(q);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(found[c], expected[c], 2e-9 * (expected[c] + 1e-12)) << i; // the textbook form of D loses 1e-16 / alpha^2 to cancellation
    }
}

TEST(ClearCoat, FloatAgreesWithDouble) {
    CoatedQueries generate{QueryGenerator(32, 1e-2)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const Evaluation f = evaluateFloat(q), d = evaluateDouble(q);
        const double alpha = std::max(double(q.clearcoatRoughness) * q.clearcoatRoughness, 1e-3);
        ASSERT_NEAR(f.pdf, d.pdf, 1e-4 * d.pdf) << i;
        for (int c = 0; c < 3; ++c) {
            // A difference of coat and base, each of which is known to 1e-4.
            const double terms = d.value[c] + evaluateDouble(uncoated(q)).value[c] + std::abs(d.clearcoat[c]);
            ASSERT_NEAR(f.value[c], d.value[c], 1e-4 * d.value[c]) << i;
            ASSERT_NEAR(f.clearcoat[c], d.clearcoat[c], 1e-4 * terms) << i;
            ASSERT_NEAR(f.clearcoatRoughness[c], d.clearcoatRoughness[c], 1e-4 * d.value[c] * 4 * q.clearcoatRoughness / alpha) << i;
        }
    }
}

TEST(ClearCoat, DerivativesAgreeWithCentralDifferences) {
    Library library;
    CoatedQueries generate{QueryGenerator(33, 2e-2)};
    int compared = 0;
    for (int i = 0; i < 10000; ++i) {
        const Query q = generate();
        const Library::Surface s = surfaceOf(q);
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        Library::BsdfDerivatives d;
        const glm::dvec3 value = library.bsdfCosDerivatives(s, n, wo, wi, d), base = evaluateDouble(uncoated(q)).value;
        if (value == glm::dvec3(0))
            continue;
        ++compared;
        const SurfaceDifferences differences{library, s, n, wo, wi};
        const double rough = q.clearcoatRoughness, alpha = std::min(std::max(rough * rough, 1e-3), std::max(double(q.roughness) * q.roughness, 1e-3));
        const glm::dvec3 byCoat = differences.by([](auto& t, double h) { t.lobe[0] += h; }, 0.1), byColour = differences.by([](auto& t, double h) { t.baseColor += h; }, 0.1);
        const glm::dvec3 byRoughness = differences.by([](auto& t, double h) { t.lobe[1] += h; }, 1e-3 * std::max(rough, 0.01));
        const double margin = std::min(std::abs(glm::dot(n, wo)), std::abs(glm::dot(n, wi))), step = std::min(alpha, margin);
        for (int c = 0; c < 3; ++c) {
            const double size = value[c] + base[c] + std::abs(d.at[kAtClearcoat][c]);
            ASSERT_NEAR(d.at[kAtClearcoat][c], byCoat[c], 1e-9 * size) << i;
            ASSERT_NEAR(d.at[kAtBaseColor][c], byColour[c], 1e-8 * (size + std::abs(byColour[c]))) << i;
            if (std::abs(rough * rough / 1e-3 - 1) > 0.05) { // away from the kink at the floor
                ASSERT_NEAR(d.at[kAtClearcoatRoughness][c], byRoughness[c], 1e-6 * size * (1 + 4 * rough / std::max(rough * rough, 1e-3))) << i;
            }
        }
        differences.expectNormal(d, step, value + base + glm::abs(d.at[kAtClearcoat]), 2e-6, i);
    }
    EXPECT_GT(compared, 7000);
}

Query coatOver(float metallic, float factor, float roughness, float cosine, const glm::vec3& baseColor) {
    Query q;
    q.baseColor = baseColor;
    q.roughness = 0.6f;
    q.metallic = metallic;
    q.specular = 0;
    q.clearcoat = factor;
    q.clearcoatRoughness = roughness;
    q.model = kCoated;
    q.wo = {std::sqrt(1 - cosine * cosine), 0, cosine};
    return q;
}

HemisphereMesh meshFor(const Query& q) {
    const double alpha = std::max(double(q.clearcoatRoughness) * q.clearcoatRoughness, 1e-3);
    return {{-q.wo.x, -q.wo.y, q.wo.z}, 0.5 * alpha, 0.5 * alpha * q.wo.z};
}

// 24 cases at a level of 1 % together (Bonferroni), the seeds fixed.
TEST(ClearCoat, DirectionsFollowTheirDensity) {
    int cases = 0;
    for (const float metallic : {0.0f, 1.0f})
        for (const auto& [factor, roughness] : {std::pair(1.0f, 0.05f), std::pair(0.5f, 0.3f), std::pair(0.0f, 0.2f), std::pair(1.0f, 1.0f)})
            for (const float cosine : {1.0f, 0.6f, 0.1f}) {
                const Query q = coatOver(metallic, factor, roughness, cosine, glm::vec3(0.3f, 0.8f, 0.1f));
                double integral = 0;
                const double significance = significanceOfDirections(q, meshFor(q), std::uint32_t(500 + cases++), integral);
                ASSERT_LE(integral, 1 + 1e-4);
                EXPECT_GE(significance, 0.01 / 24) << "metallic " << metallic << " coat " << factor << ", " << roughness << " cosine " << cosine;
            }
    EXPECT_EQ(cases, 24);
}

// Under a uniform sky: a smooth coat over a white diffuse base returns what arrives, a rough one less, never more.
TEST(ClearCoat, ReflectsAtMostWhatArrives) {
    for (const float roughness : {0.0f, 0.3f, 1.0f})
        for (const float cosine : {1.0f, 0.3f, 0.05f}) {
            Query q = coatOver(0, 1, roughness, cosine, glm::vec3(1));
            const std::vector<double> parts = meshFor(q).integrate([&](const glm::dvec3& wi) {
                q.wi = glm::vec3(wi);
                return evaluateDouble(q).value.x;
            });
            const double reflected = std::accumulate(parts.begin(), parts.end(), 0.0);
            EXPECT_LE(reflected, 1 + 1e-5) << "roughness " << roughness << " cosine " << cosine;
            if (roughness == 0 && cosine > 0.1f) {
                EXPECT_NEAR(reflected, 1, 0.02 * (0.04 + 0.96 * std::pow(1 - cosine, 5)) + 1e-5) << "cosine " << cosine;
            }
        }
}

} // namespace
} // namespace cmpg::test
