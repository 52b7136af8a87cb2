// Material values and derivatives: float against double, derivatives against differences, energy, reciprocity, extremes.
#include "central_difference.h"
#include "evaluate.h"
#include "relative_error.h"
#include "shader_double.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <sstream>

namespace cmpg::test {
namespace {

std::string describe(const Query& q) {
    std::ostringstream out;
    const auto vec = [](const glm::vec3& v) { return std::to_string(v.x) + "," + std::to_string(v.y) + "," + std::to_string(v.z); };
    out << "baseColor " << vec(q.baseColor) << " roughness " << q.roughness << " metallic " << q.metallic << " specular " << q.specular
        << " ior " << q.ior << " n.wo " << glm::dot(q.normal, q.wo) << " n.wi " << glm::dot(q.normal, q.wi);
    return out.str();
}

Query with(Query q, float Query::* member, float value) {
    q.*member = value;
    return q;
}

// A quantity that is a difference of positive terms is compared relative to the terms' sum: it crosses 0.
void comparePrecisions(double minCosine, double tolerance, double normalTolerance) {
    QueryGenerator generate(17, minCosine);
    for (int i = 0; i < 300000; ++i) {
        const Query q = generate();
        const Evaluation f = evaluateFloat(q), d = evaluateDouble(q);
        const glm::dvec3 pdf(d.pdf);
        const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3);
        const glm::dvec3 roughness = d.value * (4.0 * q.roughness / alpha); // |d ln D / d alpha| <= 2 / alpha
        const glm::dvec3 metallic = evaluateDouble(with(q, &Query::metallic, 0)).value + evaluateDouble(with(q, &Query::metallic, 1)).value;
        const glm::dvec3 specular = evaluateDouble(with(q, &Query::specular, 0)).value + evaluateDouble(with(q, &Query::specular, 1)).value;
        ASSERT_LE(relativeError(f.value, d.value, d.value), tolerance) << "value; " << describe(q);
        ASSERT_LE(relativeError(glm::dvec3(f.pdf), pdf, pdf), tolerance) << "density; " << describe(q);
        ASSERT_LE(relativeError(f.baseColor, d.baseColor, d.baseColor), tolerance) << "d baseColor; " << describe(q);
        ASSERT_LE(relativeError(f.roughness, d.roughness, roughness), tolerance) << "d roughness; " << describe(q);
        ASSERT_LE(relativeError(f.metallic, d.metallic, metallic), tolerance) << "d metallic; " << describe(q);
        ASSERT_LE(relativeError(f.specular, d.specular, specular), tolerance) << "d specular; " << describe(q);
        for (int c = 0; c < 3; ++c) {
            ASSERT_LE(glm::length(f.normal[c] - d.normal[c]), normalTolerance * glm::length(d.normal[c])) << "d normal; " << describe(q);
        }
    }
}

TEST(BsdfPrecision, FloatAgreesWithDoubleToOnePartInTenThousand) { comparePrecisions(1e-2, 1e-4, 1e-4); }

// A cosine of 1e-3 is itself known to 6e-5 only in float; the gradient by the normal is a difference of such terms.
TEST(BsdfPrecision, FloatAgreesWithDoubleNearGrazing) { comparePrecisions(1e-3, 1e-4, 1e-3); }

using Library = shader_double::ShaderLibrary;
using shader_double::kAtBaseColor, shader_double::kAtRoughness, shader_double::kAtMetallic, shader_double::kAtSpecular, shader_double::kAtNormal;

Library::Surface surfaceOf(const Query& q) {
    return {glm::dvec3(q.baseColor), q.roughness, q.metallic, q.specular, glm::dvec3(q.specularColor), q.ior, ~0u, q.model};
}

TEST(BsdfDerivatives, AgreeWithCentralDifferences) {
    Library library;
    QueryGenerator generate(23, 1e-2);
    int compared = 0;
    for (int i = 0; i < 30000; ++i) {
        const Query q = generate();
        Library::Surface s = surfaceOf(q);
        const double alpha = std::max(s.roughness * s.roughness, 1e-3);
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        Library::BsdfDerivatives d;
        const glm::dvec3 value = library.bsdfCosDerivatives(s, n, wo, wi, d);
        if (value == glm::dvec3(0) && d.at[kAtMetallic] == glm::dvec3(0)) continue;
        ++compared;
        const auto moved = [&](auto change) {
            return [&, change](double h) {
                Library::Surface t = s;
                change(t, h);
                return library.bsdfCos(t, n, wo, wi);
            };
        };
        // Relative to the size of the value over the range of the parameter, which is what rounding scales with.
        const auto check = [&](const char* what, const glm::dvec3& ours, const glm::dvec3& differences, const glm::dvec3& scale) {
            EXPECT_LE(relativeError(ours, differences, scale), 1e-6) << what << "; " << describe(q);
        };
        const glm::dvec3 metallic = library.bsdfCos(surfaceOf(with(q, &Query::metallic, 0)), n, wo, wi)
                                  + library.bsdfCos(surfaceOf(with(q, &Query::metallic, 1)), n, wo, wi);
        const glm::dvec3 all = metallic + library.bsdfCos(surfaceOf(with(q, &Query::specular, 0)), n, wo, wi)
                             + library.bsdfCos(surfaceOf(with(q, &Query::specular, 1)), n, wo, wi);
        // The material is linear in these three, so any step will do.
        check("baseColor", d.at[kAtBaseColor], difference(moved([](auto& t, double h) { t.baseColor += h; }), 0.1), all + glm::abs(d.at[kAtBaseColor]));
        check("metallic", d.at[kAtMetallic], difference(moved([](auto& t, double h) { t.metallic += h; }), 0.1), all);
        check("specular", d.at[kAtSpecular], difference(moved([](auto& t, double h) { t.specular += h; }), 0.1), all);
        if (std::abs(s.roughness * s.roughness / 1e-3 - 1) > 0.05) { // away from the kink at the floor
            check("roughness", d.at[kAtRoughness], difference(moved([](auto& t, double h) { t.roughness += h; }), 1e-3 * std::max(s.roughness, 0.01)),
                  value * (4 * s.roughness / alpha) + glm::abs(d.at[kAtRoughness]));
        }
        // A normal turned towards each axis and renormalised, by much less than the lobe's width and the smaller cosine.
        const double margin = std::min(std::abs(glm::dot(n, wo)), std::abs(glm::dot(n, wi)));
        const glm::dmat3 gradient = glm::transpose(glm::dmat3(d.at[kAtNormal], d.at[kAtNormal + 1], d.at[kAtNormal + 2])); // column: channel
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 direction(0);
            direction[axis] = 1;
            const glm::dvec3 finite = difference([&](double h) { return library.bsdfCos(s, glm::normalize(n + h * direction), wo, wi); },
                                                 2e-3 * std::min(alpha, margin));
            for (int c = 0; c < 3; ++c) {
                // Rounding of the difference itself is about 1e-16 value / step.
                EXPECT_LE(std::abs(gradient[c][axis] - finite[c]), 1e-6 * (glm::length(gradient[c]) + value[c] / std::min(alpha, margin)))
                    << "normal " << axis << "; " << describe(q);
            }
        }
        if (HasFailure()) return;
    }
    EXPECT_GT(compared, 20000);
}

TEST(BsdfDerivatives, RoughnessHasNoneAtAndBelowTheFloor) {
    Query q;
    q.metallic = 1;
    for (const float roughness : {0.0f, 0.01f, 0.0316f}) {
        q.roughness = roughness;
        EXPECT_EQ(evaluateDouble(q).roughness, glm::dvec3(0));
        EXPECT_EQ(evaluateDouble(q).value, evaluateDouble(with(q, &Query::roughness, 0)).value);
    }
    EXPECT_NE(evaluateDouble(with(q, &Query::roughness, 0.0317f)).roughness, glm::dvec3(0));
}

TEST(BsdfDerivatives, SwitchedOffAreZeroAndChangeNothingElse) {
    Library all, none;
    none.kDiffBaseColor = none.kDiffRoughness = none.kDiffMetallic = none.kDiffSpecular = none.kDiffNormal = false;
    const Library::Surface s{glm::dvec3(0.3, 0.5, 0.7), 0.4, 0.3, 0.8, glm::dvec3(1), 1.5, ~0u, 0};
    const glm::dvec3 n(0, 0, 1), wo = glm::normalize(glm::dvec3(1, 0, 2)), wi = glm::normalize(glm::dvec3(-1, 0.5, 1));
    Library::BsdfDerivatives a, b;
    EXPECT_EQ(all.bsdfCosDerivatives(s, n, wo, wi, a), all.bsdfCos(s, n, wo, wi));
    const glm::dvec3 zero(0);
    EXPECT_EQ(none.bsdfCosDerivatives(s, n, wo, wi, b), all.bsdfCos(s, n, wo, wi));
    for (const glm::dvec3& v : b.at) EXPECT_EQ(v, zero);
    for (const glm::dvec3& v : {a.at[kAtBaseColor], a.at[kAtRoughness], a.at[kAtMetallic], a.at[kAtSpecular], a.at[kAtNormal]}) EXPECT_NE(v, zero);
}

// The formulas of glTF 2.0 appendix B and KHR_materials_specular written down directly, in their textbook form.
glm::dvec3 textbook(const Library::Surface& s, const glm::dvec3& n, const glm::dvec3& wo, const glm::dvec3& wi) {
    const double no = glm::dot(n, wo), ni = glm::dot(n, wi);
    if (no * ni <= 0) return glm::dvec3(0);
    const glm::dvec3 h = glm::normalize(wo + wi);
    const double a2 = std::pow(std::max(s.roughness * s.roughness, 1e-3), 2), nh = glm::dot(n, h);
    const double distribution = a2 / (glm::pi<double>() * std::pow(nh * nh * (a2 - 1) + 1, 2));
    const auto masking = [&](double c) { return 2 * std::abs(c) / (std::abs(c) + std::sqrt(a2 + (1 - a2) * c * c)); };
    const double ggx = distribution * masking(no) * masking(ni) / (4 * std::abs(no * ni));
    const double grazing = std::pow(1 - std::abs(glm::dot(wo, h)), 5);
    const glm::dvec3 f0 = glm::min(std::pow((1 - s.ior) / (1 + s.ior), 2) * s.specularColor, glm::dvec3(1));
    const glm::dvec3 fr = f0 + (1.0 - f0) * grazing;
    const double strongest = std::max({fr.x, fr.y, fr.z});
    const glm::dvec3 dielectric = (1 - s.specular * strongest) * s.baseColor / glm::pi<double>() + s.specular * fr * ggx;
    const glm::dvec3 metal = (s.baseColor + (1.0 - s.baseColor) * grazing) * ggx;
    return std::abs(ni) * glm::mix(dielectric, metal, s.metallic);
}

TEST(Bsdf, EqualsTheFormulasOfTheFormat) {
    Library library;
    QueryGenerator generate(5, 0.05);
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        const glm::dvec3 expected = textbook(surfaceOf(q), n, wo, wi);
        // The textbook form of D loses 1e-16 / alpha^2 to cancellation.
        ASSERT_LE(relativeError(library.bsdfCos(surfaceOf(q), n, wo, wi), expected, expected + 1e-12), 2e-9) << describe(q);
    }
}

TEST(Bsdf, IsReciprocal) {
    Library library;
    QueryGenerator generate(6, 1e-3);
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 n(q.normal), wo(q.wo), wi(q.wi);
        const glm::dvec3 there = library.bsdfCos(surfaceOf(q), n, wo, wi) * std::abs(glm::dot(n, wo));
        const glm::dvec3 back = library.bsdfCos(surfaceOf(q), n, wi, wo) * std::abs(glm::dot(n, wi));
        ASSERT_LE(relativeError(there, back, back), 1e-9) << describe(q);
    }
}

TEST(Bsdf, IsZeroAcrossTheSurfaceAndAtItsEdge) {
    Library library;
    const Library::Surface s{glm::dvec3(1), 0.3, 0.5, 1, glm::dvec3(1), 1.5, ~0u, 0};
    const glm::dvec3 n(0, 0, 1), up = glm::normalize(glm::dvec3(1, 0, 1)), down = glm::normalize(glm::dvec3(1, 0, -1)), edge(1, 0, 0);
    for (const auto& [wo, wi] : {std::pair(up, down), std::pair(down, up), std::pair(up, edge), std::pair(edge, up), std::pair(edge, edge),
                                 std::pair(edge, -edge)}) {
        Library::BsdfDerivatives d;
        EXPECT_EQ(library.bsdfCosDerivatives(s, n, wo, wi, d), glm::dvec3(0));
        EXPECT_EQ(library.bsdfPdf(s, n, wo, wi), 0);
        for (const glm::dvec3& v : d.at) EXPECT_EQ(v, glm::dvec3(0));
    }
    EXPECT_EQ(library.bsdfCos(s, -n, up, up), library.bsdfCos(s, n, up, up)); // two-sided
}

TEST(Bsdf, FloatStaysFiniteAtExtremes) {
    const auto finite = [](const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    for (const float roughness : {0.0f, 1e-20f, 0.0316f, 0.5f, 1.0f}) {
        for (const float cosO : {1e-30f, 1e-9f, 2e-9f, 1e-6f, 0.5f, 1.0f}) {
            for (const float cosI : {1e-30f, 1e-9f, 2e-9f, 1e-6f, 0.5f, 1.0f}) {
                for (const float turn : {0.0f, 1e-6f, 3.1415927f}) {
                    for (const float ior : {0.0f, 1.0f, 1.5f, 1e30f}) {
                        for (const float metallic : {0.0f, 0.5f, 1.0f}) {
                            Query q;
                            q.roughness = roughness;
                            q.metallic = metallic;
                            q.ior = ior;
                            q.specularColor = glm::vec3(0, 1, 1e6f);
                            q.baseColor = glm::vec3(0, 0.5f, 1);
                            const float sinO = std::sqrt(1 - cosO * cosO), sinI = std::sqrt(1 - cosI * cosI);
                            q.wo = glm::vec3(sinO, 0, cosO);
                            q.wi = glm::vec3(sinI * std::cos(turn), sinI * std::sin(turn), cosI);
                            const Evaluation e = evaluateFloat(q);
                            ASSERT_TRUE(finite(e.value) && std::isfinite(e.pdf) && finite(e.baseColor) && finite(e.roughness) && finite(e.metallic)
                                        && finite(e.specular) && finite(e.normal[0]) && finite(e.normal[1]) && finite(e.normal[2]))
                                << describe(q);
                            ASSERT_TRUE(glm::all(glm::greaterThanEqual(e.value, glm::dvec3(0)))) << describe(q);
                            ASSERT_TRUE(e.pdf > 0 || e.value == glm::dvec3(0)) << describe(q);
                        }
                    }
                }
            }
        }
    }
}

} // namespace
} // namespace cmpg::test
