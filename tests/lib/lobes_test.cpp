// Dielectrics, conductors and plastics: Fresnel's equations, refraction, and values, densities and derivatives of the lobes, against known truths, against
// differences, against the float build, and against Mitsuba's plugins (tests/reference/make_lobes.py).
#include "evaluate.h"

#include "hemisphere_mesh.h"
#include "scene/coat_table.h"
#include "shader_double.h"
#include "statistics.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numeric>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;
using shader_double::kAtBaseColor, shader_double::kAtRoughness, shader_double::kAtSpecular, shader_double::kAtNormal;

constexpr std::uint32_t model(std::uint32_t number) { return number << gpu::kModelShift; }

glm::dvec3 at(double cosine, double phi = 0.3) {
    const double r = std::sqrt(1 - cosine * cosine);
    return {r * std::cos(phi), r * std::sin(phi), cosine};
}

TEST(Fresnel, NormalIncidenceAndBrewstersAngle) {
    Library library;
    for (const double eta : {0.6, 1.0, 1.33, 1.5, 2.4}) {
        const double r = (eta - 1) / (eta + 1);
        EXPECT_NEAR(library.dielectricBoundary(1, eta).reflected, r * r, 1e-15);
        // There the light that is polarised in the plane of incidence passes, and half of the other part's reflection is left.
        const double c = 1 / std::sqrt(1 + eta * eta), s = (1 - eta * eta) / (1 + eta * eta);
        EXPECT_NEAR(library.dielectricBoundary(c, eta).reflected, 0.5 * s * s, 1e-14);
    }
}

TEST(Fresnel, EnergyAndReciprocity) {
    Library library;
    for (const double eta : {0.5, 0.9, 1.2, 1.5, 3.0})
        for (double c = 0.001; c <= 1; c += 0.013) {
            const auto there = library.dielectricBoundary(c, eta);
            EXPECT_NEAR(there.reflected + there.transmitted, 1, 1e-13);
            if (there.cosine == 0) {
                EXPECT_LE(std::sqrt(1 - c * c), 1.0);
                EXPECT_GE(std::sqrt(1 - c * c), eta * (1 - 1e-12)) << "total reflection only beyond the critical angle";
                continue;
            }
            EXPECT_NEAR(there.cosine * there.cosine, 1 - (1 - c * c) / (eta * eta), 1e-13); // Snell
            EXPECT_NEAR(library.dielectricBoundary(there.cosine, 1 / eta).reflected, there.reflected, 1e-10);
            const double h = 1e-6 * c;
            const double slope = (library.dielectricBoundary(c + h, eta).transmitted - library.dielectricBoundary(c - h, eta).transmitted) / (2 * h);
            EXPECT_NEAR(library.transmittedDerivative(c, eta, there), slope, 1e-5 * (1 + std::abs(slope))) << c << " " << eta;
        }
}

TEST(Fresnel, PaneIsTheSumOfItsReflections) {
    Library library;
    for (double c = 0.02; c <= 1; c += 0.07) {
        const auto one = library.dielectricBoundary(c, 1.5), pane = library.paneBoundary(c, 1.5);
        double reflected = one.reflected, transmitted = 0, within = one.transmitted;
        for (int i = 0; i < 2000; ++i) {
            (i % 2 == 0 ? transmitted : reflected) += within * one.transmitted;
            within *= one.reflected;
        }
        EXPECT_NEAR(pane.reflected, reflected, 1e-9);
        EXPECT_NEAR(pane.transmitted, transmitted, 1e-9);
    }
}

TEST(Fresnel, ConductorsWithoutExtinctionAreDielectrics) {
    Library library;
    for (double c = 0; c <= 1; c += 0.05) {
        const glm::dvec3 r = library.conductorReflected(c, glm::dvec3(1.5, 2, 1.1), glm::dvec3(0));
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(r[i], library.dielectricBoundary(c, glm::dvec3(1.5, 2, 1.1)[i]).reflected, 1e-12);
        const glm::dvec3 mirror = library.conductorReflected(c, glm::dvec3(0), glm::dvec3(1));
        for (int i = 0; i < 3; ++i)
            EXPECT_NEAR(mirror[i], 1, 1e-12) << "eta 0 reflects all";
    }
    // Normal incidence: ((eta - 1)^2 + k^2) / ((eta + 1)^2 + k^2).
    const double eta = 0.143119, k = 3.98316;
    EXPECT_NEAR(library.conductorReflected(1, glm::dvec3(eta), glm::dvec3(k)).x, ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k), 1e-12);
}

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

// What make_lobes.py says of a material.
struct Material {
    Library library;
    Library::Surface surface;
    double alpha = 0;

    explicit Material(const nlohmann::json& m) {
        const auto rgb = [&](const char* key) {
            return m.contains(key) ? glm::dvec3(m[key][0].get<double>(), m[key][1].get<double>(), m[key][2].get<double>()) : glm::dvec3(1);
        };
        const std::string kind = m["model"];
        alpha = m.value("alpha", 0.0);
        const Microfacets microfacets = m.value("distribution", "ggx") == "beckmann" ? Microfacets::Beckmann : Microfacets::Ggx;
        surface = {rgb("colour"), alpha, 0, 0, rgb("specular"), m.value("ior", 1.5), 0, 0};
        std::uint32_t flags = (alpha > 0 ? 0 : gpu::kMaterialSmooth) | (microfacets == Microfacets::Beckmann ? gpu::kMaterialBeckmann : 0);
        if (m.value("nonlinear", false)) flags |= gpu::kMaterialNonlinear;
        if (kind == "conductor") {
            flags |= model(gpu::kModelConductor);
            const glm::dvec3 eta = rgb("eta");
            surface.metallic = eta.x;
            surface.specular = eta.y;
            surface.ior = eta.z;
            surface.specularColor = rgb("k");
        } else if (kind == "plastic") {
            flags |= model(gpu::kModelPlastic);
            if (alpha > 0)
                addCoat(microfacets);
            else
                surface.metallic = CoatTable::reflectedDiffuse(1 / surface.ior);
        } else {
            flags |= model(kind == "dielectric" ? gpu::kModelDielectric : gpu::kModelThinDielectric);
        }
        surface.model = flags;
    }

    void addCoat(Microfacets microfacets) {
        std::vector<glm::vec4> texels(std::size_t(gpu::kCoatRows) * gpu::kCoatColumns);
        CoatTable(surface.ior, microfacets).write(0, gpu::kCoatRows - 1, texels);
        library.coatTexels.assign(texels.begin(), texels.end());
    }
};

nlohmann::json lobes() {
    std::ifstream file(std::string(CMPG_SOURCE_DIR) + "/tests/reference/lobes.json");
    return nlohmann::json::parse(file);
}

glm::dvec3 vec(const nlohmann::json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }

TEST(Lobes, ValuesAreMitsubas) {
    const nlohmann::json all = lobes();
    int compared = 0;
    for (const auto& set : all["pairs"]) {
        Material m(set["material"]);
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
        Material m(set["material"]);
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

std::vector<nlohmann::json> materialsOfPairs(bool dielectrics) {
    std::vector<nlohmann::json> result;
    const nlohmann::json all = lobes();
    for (const auto& set : all["pairs"])
        if ((set["material"]["model"] == "dielectric") == dielectrics) result.push_back(set["material"]);
    return result;
}

glm::dvec3 difference(const std::function<glm::dvec3(double)>& f, double step) {
    const auto central = [&](double h) { return (f(h) - f(-h)) / (2 * h); };
    return (4.0 * central(step / 2) - central(step)) / 3.0;
}

void expectNear(const glm::dvec3& found, const glm::dvec3& expected, const glm::dvec3& scale, const std::string& what) {
    for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(found[c], expected[c], 1e-5 * scale[c] + 1e-9) << what << " channel " << c;
}

TEST(Lobes, DerivativesAreThoseOfTheValue) {
    std::mt19937 random(9);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(false)) {
        Material m(json);
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
        Material m({{"model", "plastic"}, {"ior", 1.5}, {"alpha", 0.1}, {"distribution", microfacets == Microfacets::Ggx ? "ggx" : "beckmann"}});
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

double total(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

Query query(const Material& m, const glm::vec3& wo) {
    Query q;
    q.baseColor = m.surface.baseColor;
    q.roughness = float(m.surface.roughness);
    q.metallic = float(m.surface.metallic);
    q.specular = float(m.surface.specular);
    q.specularColor = m.surface.specularColor;
    q.ior = float(m.surface.ior);
    q.model = m.surface.model;
    q.wo = wo;
    return q;
}

TEST(Lobes, DrawnDirectionsFollowTheirDensity) {
    const std::vector<nlohmann::json> materials = materialsOfPairs(false);
    int cases = 0;
    for (const auto& json : materials)
        for (const double cosine : {0.95, 0.5, 0.1}) {
            Material m(json);
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
    EXPECT_EQ(cases, 27);
}

// Both sides, from both sides. Bands of height, each of as many sectors; refraction ends at an edge, so they are integrated by many points.
TEST(RoughDielectric, DrawnDirectionsFollowTheirDensity) {
    constexpr int kBands = 80, kSectors = 10, kPoints = 40, kTurns = 480;
    const std::vector<nlohmann::json> materials = materialsOfPairs(true);
    int cases = 0;
    for (const auto& json : materials)
        for (const double cosine : {0.95, 0.5, 0.1, -0.9, -0.3}) {
            Material m(json);
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
    EXPECT_EQ(cases, 15);
}

TEST(RoughDielectric, DerivativesAreThoseOfTheValue) {
    std::mt19937 random(19);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(true)) {
        Material m(json);
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
        }
        EXPECT_GT(bright, 300);
    }
}

// f(wo, wi) / eta^2 of the side of wi is symmetric: radiance over the squared index goes both ways alike.
TEST(RoughDielectric, IsReciprocal) {
    std::mt19937 random(23);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& json : materialsOfPairs(true)) {
        Material m(json);
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

// White materials reflect at most what arrives; a nonlinear white plastic gives back all that its coat does not lose.
TEST(Lobes, Energy) {
    for (nlohmann::json json : materialsOfPairs(false)) {
        json["colour"] = {1, 1, 1};
        json["specular"] = {1, 1, 1};
        Material m(json);
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
        Material m(json);
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
