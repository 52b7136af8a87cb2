// Anisotropic microfacets of metallic-roughness: the extension's formula in double precision, derivatives, sampling, energy. Those with two alphas are
// compared with Mitsuba's in lobes_test.cpp and rough_dielectric_test.cpp.
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

using shader_double::kAtAnisotropy, shader_double::kAtBaseColor, shader_double::kAtRoughness;
using Library = shader_double::ShaderLibrary;
constexpr std::size_t kStrength = gpu::kSlotAnisotropy - gpu::kCommonSlots; // in Surface::lobe

struct BrushedQueries {
    QueryGenerator base;
    std::mt19937 random{51};
    Query operator()() {
        Query q = base();
        std::uniform_real_distribution<float> uniform(0, 1);
        q.anisotropy = random() % 8 == 0 ? float(random() % 2) : uniform(random);
        q.model |= gpu::kMaterialAnisotropic | (random() % 4 == 0 ? gpu::kMaterialAspect : 0);
        // In the plane of a normal near the query's, as where a normal map turns it.
        glm::vec3 near;
        do {
            near = glm::normalize(q.normal + 0.6f * (glm::vec3(uniform(random), uniform(random), uniform(random)) - 0.5f));
            q.tangent = glm::cross(near, glm::vec3(uniform(random), uniform(random), uniform(random)) - 0.5f);
        } while (glm::length(q.tangent) < 0.1f || std::abs(glm::dot(glm::normalize(q.tangent), q.normal)) > 0.9f);
        q.tangent = glm::normalize(q.tangent);
        return q;
    }
};

Library::Surface surfaceOf(const Query& q) {
    return {glm::dvec3(q.baseColor), q.roughness, q.metallic, q.specular, glm::dvec3(q.specularColor), q.ior, ~0u, q.model, {0, 0, q.anisotropy}, glm::dvec3(q.tangent)};
}

// f |cos| with directions that are unit vectors in double precision.
glm::dvec3 valueOf(const Query& q) {
    Library library;
    return library.bsdfCos(surfaceOf(q), glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo)), glm::normalize(glm::dvec3(q.wi)));
}

// Appendix B of glTF 2.0 with D of KHR_materials_anisotropy (or Burley's alphas) and Smith's masking for it, wo and wi apart; times |cos|.
glm::dvec3 textbook(const Query& q) {
    glm::dvec3 n = glm::normalize(glm::dvec3(q.normal));
    const glm::dvec3 wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi)), h = glm::normalize(wo + wi);
    if (glm::dot(n, wo) * glm::dot(n, wi) <= 0)
        return glm::dvec3(0);
    n = glm::dot(n, wo) < 0 ? -n : n;
    const glm::dvec3 t = glm::normalize(glm::dvec3(q.tangent) - n * glm::dot(n, glm::dvec3(q.tangent))), b = glm::cross(n, t);
    const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3), aspect = std::sqrt(1 - 0.9 * q.anisotropy);
    const bool byAspect = (q.model & gpu::kMaterialAspect) != 0;
    const double at = byAspect ? alpha / aspect : glm::mix(alpha, 1.0, double(q.anisotropy) * q.anisotropy), ab = byAspect ? std::max(alpha * aspect, 1e-3) : alpha;
    const glm::dvec3 stretched(ab * glm::dot(t, h), at * glm::dot(b, h), at * ab * glm::dot(n, h));
    const double w2 = at * ab / glm::dot(stretched, stretched), distribution = at * ab * w2 * w2 / glm::pi<double>();
    const auto masking = [&](const glm::dvec3& w) {
        const double c = glm::dot(n, w), tangential = (std::pow(at * glm::dot(t, w), 2) + std::pow(ab * glm::dot(b, w), 2)) / (c * c);
        return 2 / (1 + std::sqrt(1 + tangential));
    };
    const double no = glm::dot(n, wo), ni = glm::dot(n, wi), layer = distribution * masking(wo) * masking(wi) / (4 * no * ni);
    const double grazing = std::pow(1 - glm::dot(wo, h), 5), r = (1 - double(q.ior)) / (1 + double(q.ior));
    const glm::dvec3 f0 = glm::min(r * r * glm::dvec3(q.specularColor), 1.0), fr = f0 + (1.0 - f0) * grazing, base(q.baseColor);
    const double most = std::max({fr.x, fr.y, fr.z});
    const glm::dvec3 dielectric = (1 - q.specular * most) * base / glm::pi<double>() + double(q.specular) * fr * layer;
    return glm::mix(dielectric, (base + (1.0 - base) * grazing) * layer, double(q.metallic)) * ni;
}

TEST(Anisotropy, IsWhatTheExtensionSays) {
    BrushedQueries generate{QueryGenerator(61, 0.05)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 found = valueOf(q), expected = textbook(q);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(found[c], expected[c], 2e-9 * (expected[c] + 1e-12)) << i; // the textbook's forms lose 1e-16 / alpha^2 to cancellation
    }
}

// Without strength there is no direction.
TEST(Anisotropy, OfNoStrengthIsNone) {
    BrushedQueries generate{QueryGenerator(62, 1e-2)};
    for (int i = 0; i < 20000; ++i) {
        Query q = generate();
        q.anisotropy = 0;
        const Evaluation with = evaluateDouble(q);
        q.model &= ~gpu::kMaterialAnisotropic;
        const Evaluation without = evaluateDouble(q);
        ASSERT_NEAR(with.pdf, without.pdf, 1e-6 * without.pdf) << i;
        for (int c = 0; c < 3; ++c) {
            const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3), size = without.value[c];
            ASSERT_NEAR(with.value[c], without.value[c], 1e-6 * size) << i;
            ASSERT_NEAR(with.roughness[c], without.roughness[c], 1e-5 * size * 4 * q.roughness / alpha) << i;
            for (int axis = 0; axis < 3; ++axis)
                ASSERT_NEAR(with.normal[c][axis], without.normal[c][axis], 1e-5 * (glm::length(without.normal[c]) + size)) << i;
        }
    }
}

TEST(Anisotropy, FloatAgreesWithDouble) {
    BrushedQueries generate{QueryGenerator(63, 1e-2)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const Evaluation f = evaluateFloat(q), d = evaluateDouble(q);
        const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3);
        ASSERT_NEAR(f.pdf, d.pdf, 1e-4 * d.pdf) << i;
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(f.value[c], d.value[c], 1e-4 * d.value[c]) << i;
            ASSERT_NEAR(f.roughness[c], d.roughness[c], 1e-4 * d.value[c] * 4 * q.roughness / alpha) << i;
            ASSERT_NEAR(f.anisotropy[c], d.anisotropy[c], 1e-4 * d.value[c] * 4 / alpha) << i;
        }
    }
}

TEST(Anisotropy, DerivativesAgreeWithCentralDifferences) {
    Library library;
    BrushedQueries generate{QueryGenerator(64, 2e-2)};
    int compared = 0;
    for (int i = 0; i < 10000; ++i) {
        const Query q = generate();
        const Library::Surface s = surfaceOf(q);
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        Library::BsdfDerivatives d;
        const glm::dvec3 value = library.bsdfCosDerivatives(s, n, wo, wi, d);
        if (value == glm::dvec3(0))
            continue;
        ++compared;
        const SurfaceDifferences differences{library, s, n, wo, wi};
        const double rough = q.roughness, alpha = std::max(rough * rough, 1e-3), aspect = q.model & gpu::kMaterialAspect ? std::sqrt(1 - 0.9 * q.anisotropy) : 1;
        const glm::dvec3 byColour = differences.by([](auto& t, double h) { t.baseColor += h; }, 0.1);
        const glm::dvec3 byRoughness = differences.by([](auto& t, double h) { t.roughness += h; }, 1e-3 * std::max(rough, 0.01));
        const glm::dvec3 byStrength = differences.by([](auto& t, double h) { t.lobe[kStrength] += h; }, 1e-3 * alpha);
        const double margin = std::min(std::abs(glm::dot(n, wo)), std::abs(glm::dot(n, wi))), step = std::min(alpha, margin);
        for (int c = 0; c < 3; ++c) {
            const double size = value[c];
            ASSERT_NEAR(d.at[kAtBaseColor][c], byColour[c], 1e-8 * (size + std::abs(byColour[c]))) << i;
            if (std::abs(alpha * aspect / 1e-3 - 1) > 0.05) {
                ASSERT_NEAR(d.at[kAtAnisotropy][c], byStrength[c], 1e-6 * size * (1 + 4 / alpha)) << i;
            }
            if (std::abs(rough * rough / 1e-3 - 1) > 0.05 && std::abs(rough * rough * aspect / 1e-3 - 1) > 0.05) { // away from the kinks at the floor
                ASSERT_NEAR(d.at[kAtRoughness][c], byRoughness[c], 1e-6 * size * (1 + 4 * rough / alpha)) << i;
            }
        }
        differences.expectNormal(d, step, value, 2e-6, i);
    }
    EXPECT_GT(compared, 7000);
}

Query brushed(float roughness, float strength, float cosine, float phi) {
    Query q;
    q.baseColor = glm::vec3(1);
    q.roughness = roughness;
    q.metallic = 1;
    q.anisotropy = strength;
    q.model = gpu::kMaterialAnisotropic;
    const float r = std::sqrt(1 - cosine * cosine);
    q.wo = {r * std::cos(phi), r * std::sin(phi), cosine};
    return q;
}

HemisphereMesh meshFor(const Query& q) {
    const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3);
    return {{-q.wo.x, -q.wo.y, q.wo.z}, 0.25 * alpha, 0.25 * alpha * q.wo.z};
}

// 36 cases at a level of 1 % together (Bonferroni), the seeds fixed.
TEST(Anisotropy, DirectionsFollowTheirDensity) {
    int cases = 0;
    for (const auto& [roughness, strength] : {std::pair(0.3f, 0.3f), std::pair(0.3f, 0.7f), std::pair(0.5f, 1.0f), std::pair(0.8f, 0.5f)})
        for (const float cosine : {1.0f, 0.6f, 0.1f})
            for (const float phi : {0.0f, 0.8f, 1.5707964f}) {
                const Query q = brushed(roughness, strength, cosine, phi);
                double integral = 0;
                const double significance = significanceOfDirections(q, meshFor(q), std::uint32_t(700 + cases++), integral);
                ASSERT_LE(integral, 1 + 1e-4);
                EXPECT_GE(significance, 0.01 / 36) << "roughness " << roughness << " strength " << strength << " cosine " << cosine << " phi " << phi;
            }
    EXPECT_EQ(cases, 36);
}

// Under a uniform sky a white metal returns what its microfacets do not mask: all of it where it is smooth, and never more than arrives.
TEST(Anisotropy, ReflectsAtMostWhatArrives) {
    for (const auto& [roughness, strength] : {std::pair(0.1f, 0.1f), std::pair(0.3f, 0.5f), std::pair(0.3f, 1.0f), std::pair(1.0f, 0.5f)})
        for (const float cosine : {1.0f, 0.5f, 0.1f})
            for (const float phi : {0.0f, 0.8f, 1.5707964f}) {
                Query q = brushed(roughness, strength, cosine, phi);
                const std::vector<double> parts = meshFor(q).integrate([&](const glm::dvec3& wi) {
                    q.wi = glm::vec3(wi);
                    return evaluateDouble(q).value.x;
                });
                const double reflected = std::accumulate(parts.begin(), parts.end(), 0.0);
                EXPECT_LE(reflected, 1 + 1e-5) << "roughness " << roughness << " strength " << strength << " cosine " << cosine << " phi " << phi;
                EXPECT_GE(reflected, roughness == 0.1f && cosine > 0.2f ? 0.99 : 0.3) << "roughness " << roughness << " strength " << strength << " cosine " << cosine << " phi " << phi;
            }
}

// A direction that stands on the normal has no part in its plane: numbers stay numbers.
TEST(Anisotropy, TakesAnyDirection) {
    BrushedQueries generate{QueryGenerator(65, 1e-2)};
    for (int i = 0; i < 2000; ++i) {
        Query q = generate();
        q.tangent = q.normal;
        const Evaluation e = evaluateFloat(q);
        glm::vec3 wi;
        sampleFloat(q, {0.3f, 0.6f, 0.1f}, wi);
        ASSERT_TRUE(std::isfinite(e.pdf) && std::isfinite(e.value.x + e.roughness.x + e.anisotropy.x + e.normal[0].x)) << i;
        ASSERT_NEAR(glm::length(wi), 1, 1e-5) << i;
    }
}

} // namespace
} // namespace cmpg::test
