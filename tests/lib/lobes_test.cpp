// Conductors and plastics, and all lobes beside Mitsuba's plugins: values, densities and derivatives, against known truths, differences, the float build.
#include "hemisphere_mesh.h"
#include "mitsuba_lobes.h"
#include "statistics.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;
using shader_double::kAtAnisotropy, shader_double::kAtBaseColor, shader_double::kAtRoughness, shader_double::kAtSpecular, shader_double::kAtNormal;

TEST(Lobes, ValuesAreMitsubas) {
    const nlohmann::json all = lobes();
    int compared = 0;
    for (const auto& set : all["pairs"]) {
        MitsubaMaterial m(set["material"]);
        const bool plastic = set["material"]["model"] == "plastic";
        for (std::size_t i = 0; i < set["wo"].size(); ++i) {
            const glm::dvec3 wo = glm::normalize(vec(set["wo"][i])), wi = glm::normalize(vec(set["wi"][i])), expected = vec(set["value"][i]);
            const glm::dvec3 found = m.library.bsdfCos(m.surface, {0, 0, 1}, wo, wi);
            // Of a plastic, Mitsuba has what its coat reflects of diffuse light from a fit, or from a quadrature of its own.
            const double tolerance = plastic ? 0.004 : 5e-4;
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(found[c], expected[c], tolerance * expected[c] + 1e-6) << set["material"] << " pair " << i << " wo.z " << wo.z << " wi.z " << wi.z;
            compared += expected.x > 0;
        }
    }
    EXPECT_GT(compared, 400);
}

TEST(Lobes, SingleDirectionsAreMitsubas) {
    const nlohmann::json all = lobes();
    for (const auto& set : all["single"]) {
        MitsubaMaterial m(set["material"]);
        for (std::size_t i = 0; i < set["wo"].size(); ++i) {
            const glm::dvec3 wo = glm::normalize(vec(set["wo"][i])), wi = vec(set["wi"][i]), expected = vec(set["carried"][i]);
            if (expected == glm::dvec3(0)) continue; // a conductor's back
            Library::BsdfDerivatives d;
            const glm::dvec3 carried = m.library.singleCosDerivatives(m.surface, {0, 0, 1}, wo, wi, d);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(carried[c], expected[c], 2e-5 * expected[c] + 1e-6) << set["material"] << " direction " << i;
            bool found = false;
            for (const double u : {0.0, 0.9999999}) {
                glm::dvec3 drawn;
                double probability;
                found |= m.library.sampleBsdf(m.surface, {0, 0, 1}, wo, {0.5, 0.5, u}, drawn, probability) && glm::distance(drawn, wi) < 2e-5;
            }
            ASSERT_TRUE(found) << set["material"] << " direction " << i;
        }
    }
}

TEST(Lobes, DerivativesAreThoseOfTheValue) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(false)) {
        MitsubaMaterial m(json);
        const Library::Surface s = m.surface;
        for (int i = 0; i < 200; ++i) {
            const glm::dvec3 n = glm::normalize(glm::dvec3(0.1, -0.2, i % 2 ? 1 : -1)), wo = at(0.05 + 0.9 * uniform(random), 6 * uniform(random)),
                             wi = at(0.05 + 0.9 * uniform(random), 6 * uniform(random));
            if (glm::dot(n, wo) * glm::dot(n, wi) < 1e-3) continue;
            Library::BsdfDerivatives d;
            const glm::dvec3 value = m.library.bsdfCosDerivatives(s, n, wo, wi, d);
            const std::string what = json.dump() + " " + std::to_string(i) + " ";
            const auto moved = [&](auto change) {
                return [&, change](double h) {
                    Library::Surface t = s;
                    change(t, h);
                    return m.library.bsdfCos(t, n, wo, wi);
                };
            };
            expectNear(d.at[kAtBaseColor], difference(moved([](auto& t, double h) { t.baseColor += h; }), 1e-3), value + 1.0, what + "baseColor");
            const bool plastic = json["model"] == "plastic";
            expectNear(d.at[kAtSpecular], plastic ? difference(moved([](auto& t, double h) { t.specularColor += h; }), 1e-3) : glm::dvec3(0), value + 1.0, what + "specular");
            // Within the pieces of the coat's table.
            expectNear(d.at[kAtRoughness], m.alpha > 0 ? difference(moved([](auto& t, double h) { t.roughness += h; }), 1e-5 * m.alpha) : glm::dvec3(0),
                       value / std::max(m.alpha, 0.1) * 10.0 + 1.0, what + "roughness");
            expectNear(d.at[kAtAnisotropy], json.contains("alpha_u") ? difference(moved([](auto& t, double h) { t.lobe[kAlphaU] += h; }), 1e-5 * m.alpha) : glm::dvec3(0),
                       value / std::max(m.alpha, 0.1) * 10.0 + 1.0, what + "anisotropy");
            for (const glm::dvec3 direction : {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}) {
                const glm::dvec3 found = glm::dmat3(d.at[kAtNormal], d.at[kAtNormal + 1], d.at[kAtNormal + 2]) * direction;
                const glm::dvec3 expected = difference([&](double h) { return m.library.bsdfCos(s, glm::normalize(n + h * direction), wo, wi); }, 1e-6);
                expectNear(found, expected, value / std::max(m.alpha, 0.05) * 20.0 + 1.0, what + "normal");
            }
        }
    }
}

// A table of the coat against the quadrature that makes it, between its nodes; what it holds is compared with Mitsuba's above.
TEST(CoatTable, InterpolatesClosely) {
    for (const Microfacets microfacets : {Microfacets::Ggx, Microfacets::Beckmann}) {
        MitsubaMaterial m({{"model", "plastic"}, {"ior", 1.5}, {"alpha", 0.1}, {"distribution", microfacets == Microfacets::Ggx ? "ggx" : "beckmann"}});
        double worst = 0;
        for (const double alpha : {0.001, 0.01, 0.05, 0.123, 0.3, 0.62, 1.0})
            for (double c = 0.05; c < 1; c += 0.0371)
                worst = std::max(worst, std::abs(m.library.coatTransmitted(m.surface, alpha, c).value - CoatTable::passed(c, alpha, 1.5, microfacets).transmitted));
        EXPECT_LT(worst, 0.003);
    }
    // Of a smooth boundary: 0.5963 from within and 0.0918 from without at 1.5 (Duntley's integrals).
    EXPECT_NEAR(CoatTable::reflectedDiffuse(1 / 1.5), 0.5963, 1e-4);
    EXPECT_NEAR(CoatTable::reflectedDiffuse(1.5), 0.0918, 1e-4);
    for (const double cosine : {0.2, 0.7}) {
        const auto nearly = CoatTable::passed(cosine, 1e-3, 1.5, Microfacets::Ggx), smooth = CoatTable::passed(cosine, 0, 1.5, Microfacets::Ggx);
        EXPECT_NEAR(nearly.reflected, smooth.reflected, 1e-3);
        EXPECT_NEAR(nearly.transmitted, smooth.transmitted, 1e-3);
    }
}

TEST(Lobes, DrawnDirectionsFollowTheirDensity) {
    const std::vector<nlohmann::json> materials = materialsOfPairs(false);
    int cases = 0;
    for (const auto& json : materials)
        for (const double cosine : {0.95, 0.5, 0.1}) {
            MitsubaMaterial m(json);
            const glm::dvec3 wo = at(cosine, 0);
            const double width = m.alpha > 0 ? 0.5 * m.alpha : 0.5;
            const HemisphereMesh mesh{{-wo.x, -wo.y, wo.z}, width, width * wo.z};
            std::vector<double> expected = mesh.integrate([&](const glm::dvec3& wi) { return m.library.bsdfPdf(m.surface, {0, 0, 1}, wo, wi); });
            std::mt19937 random(100 + cases);
            constexpr int kSamples = 100000;
            std::vector<double> observed(mesh.cells() + 1, 0.0);
            double single = 0;
            for (int i = 0; i < kSamples; ++i) {
                const auto u = [&] { return float(random() >> 8) * 0x1p-24f; };
                glm::vec3 wi;
                const float a = u(), b = u(), c = u();
                const Query q = query(m, glm::vec3(wo));
                float probability = 0;
                const bool drawn = sampleFloat(q, {a, b, c}, wi, probability);
                if (drawn && probability > 0) {
                    ASSERT_NEAR(glm::distance(glm::dvec3(wi), glm::dvec3(-wo.x, -wo.y, wo.z)), 0, 1e-5);
                    single = probability;
                }
                observed[drawn && probability == 0 ? mesh.cellOf(wi) : mesh.cells()] += 1;
            }
            const double integral = total(expected);
            ASSERT_LE(integral + single, 1 + 1e-4);
            if (single > 0) { // the share of the single direction stands for the last cell
                EXPECT_NEAR(integral, 1 - single, 2e-3);
            }
            expected.push_back(std::max(1 - integral, 0.0));
            for (double& e : expected) e *= kSamples;
            EXPECT_GE(chiSquareSignificance(observed, expected), 0.01 / double(3 * materials.size())) << json << " cosine " << cosine;
            ++cases;
        }
    EXPECT_EQ(cases, 33);
}

// White materials reflect at most what arrives; a nonlinear white plastic gives back all that its coat does not lose.
TEST(Lobes, Energy) {
    for (nlohmann::json json : materialsOfPairs(false)) {
        json["colour"] = {1, 1, 1};
        json["specular"] = {1, 1, 1};
        MitsubaMaterial m(json);
        for (const double cosine : {0.95, 0.5, 0.15}) {
            const glm::dvec3 wo = at(cosine, 0);
            const double width = m.alpha > 0 ? 0.5 * m.alpha : 0.5;
            const HemisphereMesh mesh{{-wo.x, -wo.y, wo.z}, width, width * wo.z};
            double reflected = total(mesh.integrate([&](const glm::dvec3& wi) { return m.library.bsdfCos(m.surface, {0, 0, 1}, wo, wi).x; }));
            if (json["model"] == "plastic" && m.alpha == 0) {
                Library::BsdfDerivatives d;
                reflected += m.library.singleCosDerivatives(m.surface, {0, 0, 1}, wo, {-wo.x, -wo.y, wo.z}, d).x;
            }
            EXPECT_LE(reflected, 1.001) << json << " cosine " << cosine;
            if (json["model"] == "plastic" && m.alpha == 0) {
                EXPECT_NEAR(reflected, 1, 2e-3) << json << " cosine " << cosine;
            }
        }
    }
}

TEST(Lobes, FloatIsCloseToDouble) {
    std::mt19937 random(21);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(false)) {
        if (json["model"] == "plastic" && json.contains("alpha")) continue; // their table is the double build's alone
        MitsubaMaterial m(json);
        for (int i = 0; i < 3000; ++i) {
            const glm::vec3 wo = glm::vec3(at(std::pow(1e-4, uniform(random)), 6 * uniform(random)));
            glm::vec3 wi = glm::vec3(at(std::pow(1e-4, uniform(random)), 6 * uniform(random)));
            if (i % 2 == 0) wi = glm::normalize(glm::vec3(-wo.x, -wo.y, wo.z) + float(m.alpha) * glm::vec3(uniform(random), uniform(random), uniform(random)));
            Query q = query(m, wo);
            q.wi = wi;
            const Evaluation f = evaluateFloat(q), d = evaluateDouble(q);
            const double alpha = std::max(m.alpha, 1e-3);
            // exp(-tan^2 / alpha^2) multiplies the rounding of its argument.
            const double tan2 = std::pow(std::hypot(wo.x + wi.x, wo.y + wi.y) / (double(wo.z) + wi.z), 2), steep = 1 + tan2 / (alpha * alpha);
            if (steep > 40) continue;
            for (int c = 0; c < 3; ++c) {
                ASSERT_NEAR(f.value[c], d.value[c], 3e-6 * steep * d.value[c] + 1e-12) << json << i;
                ASSERT_NEAR(f.baseColor[c], d.baseColor[c], 3e-6 * steep * d.baseColor[c] + 1e-12) << json << i;
                ASSERT_NEAR(f.roughness[c], d.roughness[c], 2e-5 * steep * d.value[c] / alpha + 1e-12) << json << i;
            }
            ASSERT_NEAR(f.pdf, d.pdf, 3e-6 * d.pdf + 1e-12) << json << i;
        }
    }
}

} // namespace
} // namespace cmpg::test
