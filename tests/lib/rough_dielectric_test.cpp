// Rough dielectrics: densities, derivatives, reciprocity.
#include "mitsuba_lobes.h"
#include "statistics.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;
using shader_double::kAtAnisotropy, shader_double::kAtBaseColor, shader_double::kAtRoughness, shader_double::kAtSpecular;

// Both sides, from both sides. Bands of height, each of as many sectors; refraction ends at an edge, so they are integrated by many points.
TEST(RoughDielectric, DrawnDirectionsFollowTheirDensity) {
    constexpr int kBands = 80, kSectors = 10, kPoints = 40, kTurns = 480;
    const std::vector<nlohmann::json> materials = materialsOfPairs(true);
    int cases = 0;
    for (const auto& json : materials)
        for (const double cosine : {0.95, 0.5, 0.1, -0.9, -0.3}) {
            MitsubaMaterial m(json);
            const glm::dvec3 wo = at(cosine, 0);
            std::vector<double> expected(kBands * kSectors, 0.0);
            for (int i = 0; i < kBands * kPoints; ++i)
                for (int k = 0; k < kTurns; ++k) {
                    const double z = -1 + 2 * (i + 0.5) / (kBands * kPoints), phi = 2 * glm::pi<double>() * (k + 0.5) / kTurns;
                    const double area = 4 * glm::pi<double>() / (double(kBands) * kPoints * kTurns);
                    expected[std::size_t(i / kPoints * kSectors + k * kSectors / kTurns)] += area * m.library.bsdfPdf(m.surface, {0, 0, 1}, wo, at(z, phi));
                }
            const double integral = total(expected);
            ASSERT_LE(integral, 1 + 1e-3) << json << " cosine " << cosine;
            expected.push_back(std::max(1 - integral, 0.0));
            constexpr int kSamples = 100000;
            std::vector<double> observed(expected.size(), 0.0);
            std::mt19937 random(300 + cases);
            for (int i = 0; i < kSamples; ++i) {
                const auto u = [&] { return float(random() >> 8) * 0x1p-24f; };
                glm::vec3 wi;
                const float x = u(), y = u(), z = u();
                float probability = 0;
                const bool drawn = sampleFloat(query(m, glm::vec3(wo)), {x, y, z}, wi, probability);
                ASSERT_EQ(probability, 0);
                const double turn = std::atan2(double(wi.y), double(wi.x)) / (2 * glm::pi<double>());
                const int band = std::min(int(0.5 * (wi.z + 1.0) * kBands), kBands - 1), sector = std::min(int((turn < 0 ? turn + 1 : turn) * kSectors), kSectors - 1);
                observed[drawn ? std::size_t(band * kSectors + sector) : observed.size() - 1] += 1;
            }
            for (double& e : expected) e *= kSamples;
            EXPECT_GE(chiSquareSignificance(observed, expected), 0.01 / double(5 * materials.size())) << json << " cosine " << cosine << " integral " << integral;
            ++cases;
        }
    EXPECT_EQ(cases, 25);
}

TEST(RoughDielectric, DerivativesAreThoseOfTheValue) {
    std::mt19937 random(19);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(true)) {
        MitsubaMaterial m(json);
        const Library::Surface s = m.surface;
        int bright = 0;
        for (int i = 0; i < 400; ++i) {
            const glm::dvec3 n(0, 0, 1), wo = at((i % 2 ? 1 : -1) * (0.05 + 0.9 * uniform(random)), 6 * uniform(random));
            glm::dvec3 wi;
            double probability;
            if (!m.library.sampleBsdf(s, n, wo, {uniform(random), uniform(random), uniform(random)}, wi, probability)) continue;
            Library::BsdfDerivatives d;
            const glm::dvec3 value = m.library.bsdfCosDerivatives(s, n, wo, wi, d);
            bright += value.x > 0;
            const auto moved = [&](auto change) {
                return [&, change](double h) {
                    Library::Surface t = s;
                    change(t, h);
                    return m.library.bsdfCos(t, n, wo, wi);
                };
            };
            expectNear(d.at[kAtBaseColor], difference(moved([](auto& t, double h) { t.baseColor += h; }), 1e-3), value + 1.0, "baseColor");
            expectNear(d.at[kAtSpecular], difference(moved([](auto& t, double h) { t.specularColor += h; }), 1e-3), value + 1.0, "specular");
            expectNear(d.at[kAtRoughness], difference(moved([](auto& t, double h) { t.roughness += h; }), 1e-4 * m.alpha), value / m.alpha + 1.0, "roughness");
            if (json.contains("alpha_u"))
                expectNear(d.at[kAtAnisotropy], difference(moved([](auto& t, double h) { t.lobe[kAlphaU] += h; }), 1e-4 * m.alpha), value / m.alpha + 1.0, "anisotropy");
        }
        EXPECT_GT(bright, 300);
    }
}

// f(wo, wi) / eta^2 of the side of wi is symmetric: radiance over the squared index goes both ways alike.
TEST(RoughDielectric, IsReciprocal) {
    std::mt19937 random(23);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(true)) {
        MitsubaMaterial m(json);
        m.surface.baseColor = m.surface.specularColor = glm::dvec3(1);
        for (int i = 0; i < 1000; ++i) {
            const glm::dvec3 n(0, 0, 1), wo = at((i % 2 ? 1 : -1) * (0.05 + 0.9 * uniform(random)), 6 * uniform(random));
            glm::dvec3 wi;
            double probability;
            if (!m.library.sampleBsdf(m.surface, n, wo, {uniform(random), uniform(random), uniform(random)}, wi, probability)) continue;
            const auto squaredIndex = [&](const glm::dvec3& w) { return w.z > 0 ? 1 : m.surface.ior * m.surface.ior; };
            const double there = m.library.bsdfCos(m.surface, n, wo, wi).x * std::abs(wo.z) * squaredIndex(wi);
            const double back = m.library.bsdfCos(m.surface, n, wi, wo).x * std::abs(wi.z) * squaredIndex(wo);
            ASSERT_NEAR(there, back, 1e-6 * there + 1e-12);
        }
    }
}

} // namespace
} // namespace cmpg::test
