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

// As those, where the coat has normals of its own, a quarter of them any, the others up to 50 degrees from those of the base; a third of the directions to
// the light are behind the base.
struct OwnNormalQueries {
    CoatedQueries coated;
    std::mt19937 random{43};
    Query operator()() {
        Query q = coated();
        std::normal_distribution<float> normal;
        const glm::vec3 towards = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
        q.coatNormal = glm::normalize(q.normal + (random() % 4 ? 0.75f : 1.5f) * towards);
        if (random() % 3 == 0)
            q.wi -= 2 * glm::dot(q.normal, q.wi) * q.normal;
        return q;
    }
};

glm::dvec3 coatNormalOf(const Query& q) { return glm::normalize(glm::dvec3(q.coatNormal == glm::vec3(0) ? q.normal : q.coatNormal)); }

Query uncoated(Query q) {
    q.model &= ~kCoated;
    return q;
}

Library::Surface surfaceOf(const Query& q) {
    return {glm::dvec3(q.baseColor), q.roughness, q.metallic, q.specular, glm::dvec3(q.specularColor), q.ior, ~0u, q.model, {q.clearcoat, q.clearcoatRoughness}, {}, {},
            q.coatNormal == glm::vec3(0) ? glm::dvec3(0) : coatNormalOf(q)};
}

// f |cos| with directions that are unit vectors in double precision.
glm::dvec3 valueOf(const Query& q) {
    Library library;
    return library.bsdfCos(surfaceOf(q), glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo)), glm::normalize(glm::dvec3(q.wi)));
}

// README of KHR_materials_clearcoat: f (1 - blend) + coat blend, blend = factor * Schlick(0.04, n.wo), the coat's specular term as that of the base; times |cos|.
// n is the coat's normal. Base and coat reflect nothing between directions on different sides of their own normals.
glm::dvec3 textbook(const Query& q) {
    const glm::dvec3 wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
    const glm::dvec3 m = coatNormalOf(q);
    const double no = std::abs(glm::dot(m, wo)), ni = std::abs(glm::dot(m, wi));
    const bool reflects = glm::dot(m, wo) * glm::dot(m, wi) > 0;
    const double blend = q.clearcoat * (0.04 + (1 - 0.04) * std::pow(1 - no, 5));
    const double a2 = std::pow(std::max(double(q.clearcoatRoughness) * q.clearcoatRoughness, 1e-3), 2), nh = glm::dot(m, glm::normalize(wo + wi));
    const double distribution = a2 / (glm::pi<double>() * std::pow(nh * nh * (a2 - 1) + 1, 2));
    const auto masking = [&](double c) { return 2 * c / (c + std::sqrt(a2 + (1 - a2) * c * c)); };
    const double coat = !reflects ? 0 : distribution * masking(no) * masking(ni) / (4 * no);
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

TEST(ClearCoat, HasNormalsOfItsOwn) {
    OwnNormalQueries generate{CoatedQueries{QueryGenerator(34, 0.05)}};
    int behind = 0, coatAlone = 0;
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 found = valueOf(q), expected = textbook(q);
        const double no = glm::dot(glm::dvec3(q.coatNormal), glm::dvec3(q.wo)), ni = glm::dot(glm::dvec3(q.coatNormal), glm::dvec3(q.wi));
        if (std::min(std::abs(no), std::abs(ni)) < 1e-3) // where the smallest cosine is cut
            continue;
        behind += no * ni < 0;
        coatAlone += no * ni > 0 && expected != glm::dvec3(0) && valueOf(uncoated(q)) == glm::dvec3(0) && glm::dot(q.normal, q.wo) * glm::dot(q.normal, q.wi) < 0;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(found[c], expected[c], 1e-8 * (expected[c] + 1e-12)) << i;
    }
    EXPECT_GT(behind, 3000);
    EXPECT_GT(coatAlone, 3000);
    // The base's normal again.
    Query q = QueryGenerator(34, 0.05)();
    q.model |= kCoated;
    q.clearcoat = 0.7f;
    q.clearcoatRoughness = 0.4f;
    q.coatNormal = q.normal;
    const glm::dvec3 same = valueOf(q);
    q.coatNormal = glm::vec3(0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(valueOf(q)[c], same[c], 1e-12 * same[c]);
}

template <class Generate> void expectFloatAgrees(Generate generate) {
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const double ownO = std::abs(glm::dot(coatNormalOf(q), glm::dvec3(q.wo))), ownI = std::abs(glm::dot(coatNormalOf(q), glm::dvec3(q.wi)));
        if (std::min(ownO, ownI) < 1e-2) // as of the base
            continue;
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

template <class Generate> void expectCentralDifferences(Generate generate) {
    Library library;
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

TEST(ClearCoat, FloatAgreesWithDouble) { expectFloatAgrees(CoatedQueries{QueryGenerator(32, 1e-2)}); }
TEST(ClearCoat, FloatAgreesWithDoubleUnderOwnNormals) { expectFloatAgrees(OwnNormalQueries{CoatedQueries{QueryGenerator(36, 1e-2)}}); }

TEST(ClearCoat, DerivativesAgreeWithCentralDifferences) { expectCentralDifferences(CoatedQueries{QueryGenerator(33, 2e-2)}); }
TEST(ClearCoat, DerivativesAgreeWithCentralDifferencesUnderOwnNormals) { expectCentralDifferences(OwnNormalQueries{CoatedQueries{QueryGenerator(35, 2e-2)}}); }

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

// The coat's normal is tilted towards where the path came from and away from it, until the coat reflects behind the base. 12 cases, as above.
TEST(ClearCoat, DirectionsFollowTheirDensityUnderOwnNormals) {
    int cases = 0;
    for (const float metallic : {0.0f, 1.0f})
        for (const float tilt : {0.5f, -0.5f, -1.2f})
            for (const float cosine : {0.8f, 0.3f}) {
                Query q = coatOver(metallic, 0.8f, 0.45f, cosine, glm::vec3(0.3f, 0.8f, 0.1f));
                q.coatNormal = {std::sin(tilt), 0, std::cos(tilt)};
                double integral = 0;
                const double significance = significanceOfDirections(q, meshFor(q), std::uint32_t(600 + cases++), integral, true);
                ASSERT_LE(integral, 1 + 1e-4);
                EXPECT_GE(significance, 0.01 / 12) << "metallic " << metallic << " tilt " << tilt << " cosine " << cosine;
            }
    EXPECT_EQ(cases, 12);
}

// Under a uniform sky: a smooth coat over a white diffuse base returns what arrives, a rough one less, never more.
TEST(ClearCoat, ReflectsAtMostWhatArrives) {
    for (const float roughness : {0.0f, 0.3f, 1.0f})
        for (const float cosine : {1.0f, 0.3f, 0.05f}) {
            for (const float tilt : {0.5f, -0.5f}) {
                Query q = coatOver(0, 1, roughness, cosine, glm::vec3(1));
                q.coatNormal = {std::sin(tilt), 0, std::cos(tilt)};
                const glm::vec3 mirrored = 2 * glm::dot(q.coatNormal, q.wo) * q.coatNormal - q.wo;
                const double alpha = std::max(double(roughness) * roughness, 1e-3);
                const HemisphereMesh mesh(glm::dvec3(mirrored.x, mirrored.y, std::abs(mirrored.z)), 0.5 * alpha, 0.5 * alpha * cosine);
                double reflected = 0;
                for (const double side : {1.0, -1.0})
                    for (const double part : mesh.integrate([&](const glm::dvec3& wi) {
                             q.wi = glm::vec3(wi.x, wi.y, side * wi.z);
                             return evaluateDouble(q).value.x;
                         }))
                        reflected += part;
                EXPECT_LE(reflected, 1 + 1e-3) << "roughness " << roughness << " cosine " << cosine << " tilt " << tilt;
            }
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
