// The sheen: its formula and its albedo in double precision, derivatives, sampling, energy.
#include "evaluate.h"

#include "drawn_directions.h"
#include "surface_differences.h"

#include <array>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <numeric>

namespace cmpg::test {
namespace {

using shader_double::kAtBaseColor, shader_double::kAtMetallic, shader_double::kAtSheenColor, shader_double::kAtSheenRoughness;
using Library = shader_double::ShaderLibrary;
constexpr std::size_t kRoughness = gpu::kSlotSheenRoughness - gpu::kCommonSlots; // in Surface::lobe
constexpr double kFloor = 0.07;

struct VelvetQueries {
    QueryGenerator base;
    std::mt19937 random{71};
    Query operator()() {
        Query q = base();
        std::uniform_real_distribution<float> uniform(0, 1);
        for (int c = 0; c < 3; ++c)
            q.sheenColor[c] = random() % 4 == 0 ? float(random() % 2) : uniform(random);
        q.sheenRoughness = random() % 8 == 0 ? float(random() % 2) : uniform(random);
        q.model |= gpu::kMaterialSheen;
        return q;
    }
};

Query withoutSheen(Query q) {
    q.model &= ~gpu::kMaterialSheen;
    return q;
}

double roughnessOf(const Query& q) { return std::max(double(q.sheenRoughness), kFloor); }
double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

Library::Surface surfaceOf(const Query& q) {
    return {glm::dvec3(q.baseColor), q.roughness, q.metallic, q.specular, glm::dvec3(q.specularColor), q.ior, ~0u, q.model,
            {0, 0, 0, q.sheenRoughness}, glm::dvec3(q.tangent), glm::dvec3(q.sheenColor)};
}

// f |cos| with directions that are unit vectors in double precision.
glm::dvec3 valueOf(const Query& q) {
    Library library;
    return library.bsdfCos(surfaceOf(q), glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo)), glm::normalize(glm::dvec3(q.wi)));
}

// README of KHR_materials_sheen: sheenDistribution * sheenVisibility. sin2: of the half vector, 1 - nh^2 without cancellation.
double extensionsSheen(double roughness, double no, double ni, double sin2) {
    const double alpha = roughness * roughness, smooth = (1 - alpha) * (1 - alpha);
    const auto l = [&](double x) {
        const double a = std::lerp(21.5473, 25.3245, smooth), b = std::lerp(3.82987, 3.32435, smooth), c = std::lerp(0.19823, 0.16801, smooth);
        const double d = std::lerp(-1.97760, -1.27393, smooth), e = std::lerp(-4.32054, -4.85967, smooth);
        return a / (1 + b * std::pow(x, c)) + d * x + e;
    };
    const auto lambda = [&](double c) { return c < 0.5 ? std::exp(l(c)) : std::exp(2 * l(0.5) - l(1 - c)); };
    const double distribution = (2 + 1 / alpha) * std::pow(sin2, 0.5 / alpha) / (2 * glm::pi<double>());
    return distribution / ((1 + lambda(no) + lambda(ni)) * 4 * no * ni);
}

// What the sheen of colour 1 reflects of a uniform sky: by Gauss and Legendre's rule over phi and the cube root of the cosine, 8 points an interval.
double albedoByIntegration(double cosine, double roughness) {
    static constexpr std::array<double, 4> x{0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static constexpr std::array<double, 4> w{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    constexpr int kIntervals = 10;
    const auto integral = [&](const std::function<double(double)>& f) { // over [0, 1]
        double sum = 0;
        for (int i = 0; i < kIntervals; ++i)
            for (int k = 0; k < 8; ++k)
                sum += w[std::size_t(k % 4)] / (2 * kIntervals) * f((i + 0.5 + 0.5 * (k < 4 ? 1 : -1) * x[std::size_t(k % 4)]) / kIntervals);
        return sum;
    };
    const double sine = std::sqrt(1 - cosine * cosine);
    return integral([&](double t) {
        const double ni = t * t * t, si = std::sqrt(1 - ni * ni);
        return 3 * t * t * ni * integral([&](double turn) {
            const glm::dvec3 sum(sine + si * std::cos(glm::pi<double>() * turn), si * std::sin(glm::pi<double>() * turn), cosine + ni);
            return 2 * glm::pi<double>() * extensionsSheen(roughness, cosine, ni, (sum.x * sum.x + sum.y * sum.y) / glm::dot(sum, sum));
        });
    });
}

glm::dvec3 textbook(const Query& q) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
    const double no = std::abs(glm::dot(n, wo)), ni = std::abs(glm::dot(n, wi));
    if (glm::dot(n, wo) * glm::dot(n, wi) <= 0)
        return glm::dvec3(0);
    Library library;
    const double m = largest(glm::dvec3(q.sheenColor)), r = roughnessOf(q);
    const double kept = std::min(1 - m * library.sheenAlbedo(no, r).value, 1 - m * library.sheenAlbedo(ni, r).value);
    const glm::dvec3 across = glm::cross(n, glm::normalize(wo + wi));
    return glm::dvec3(q.sheenColor) * (extensionsSheen(r, no, ni, glm::dot(across, across)) * ni) + std::max(kept, 0.0) * valueOf(withoutSheen(q));
}

TEST(Sheen, IsWhatTheExtensionSays) {
    VelvetQueries generate{QueryGenerator(81, 0.01)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const glm::dvec3 found = valueOf(q), expected = textbook(q);
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(found[c], expected[c], 1e-9 * expected[c] + 1e-15) << i;
    }
}

// The fit of lib/lobes/sheen.glsl and its slope by the roughness against integrals; both slopes against its own differences.
TEST(Sheen, AlbedoIsTheIntegral) {
    Library library;
    EXPECT_NEAR(albedoByIntegration(0.5, 0.5), 0.1879, 1e-4); // what other quadratures of the same integral gave
    for (const double r : {0.07, 0.085, 0.1, 0.15, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0})
        for (const double c : {0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 0.85, 1.0}) {
            const auto e = library.sheenAlbedo(c, r);
            EXPECT_NEAR(e.value, albedoByIntegration(c, r), 0.004) << "cosine " << c << " roughness " << r;
            const double slope = difference([&](double h) { return glm::dvec3(albedoByIntegration(c, r + h)); }, 2e-3 * r).x;
            EXPECT_NEAR(e.roughness, slope, 0.06 * std::max(1.0, std::abs(slope))) << "cosine " << c << " roughness " << r;
            if (c == 0.002)
                continue; // a kink
            const auto by = [&](double step, auto f) { return difference([&](double h) { return glm::dvec3(f(h)); }, step).x; };
            EXPECT_NEAR(e.cosine, by(2e-4 * c, [&](double h) { return library.sheenAlbedo(c + h, r).value; }), 1e-7 * (1 + std::abs(e.cosine)));
            EXPECT_NEAR(e.roughness, by(2e-4 * r, [&](double h) { return library.sheenAlbedo(c, r + h).value; }), 1e-7 * (1 + std::abs(e.roughness)));
        }
}

// f (n.wi) / (n.wi) is the same both ways.
TEST(Sheen, IsReciprocal) {
    VelvetQueries generate{QueryGenerator(82, 0.01)};
    for (int i = 0; i < 10000; ++i) {
        Query q = generate();
        const glm::dvec3 forth = valueOf(q) * std::abs(glm::dot(glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo))));
        std::swap(q.wo, q.wi);
        const glm::dvec3 back = valueOf(q) * std::abs(glm::dot(glm::normalize(glm::dvec3(q.normal)), glm::normalize(glm::dvec3(q.wo))));
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(forth[c], back[c], 1e-9 * forth[c] + 1e-15) << i;
    }
}

TEST(Sheen, FloatAgreesWithDouble) {
    VelvetQueries generate{QueryGenerator(83, 1e-2)};
    for (int i = 0; i < 100000; ++i) {
        const Query q = generate();
        const Evaluation f = evaluateFloat(q), d = evaluateDouble(q), base = evaluateDouble(withoutSheen(q));
        ASSERT_NEAR(f.pdf, d.pdf, 1e-4 * d.pdf) << i;
        const glm::dvec3 h = glm::normalize(glm::dvec3(q.wo) + glm::dvec3(q.wi));
        const double nh = glm::dot(h, glm::normalize(glm::dvec3(q.normal))), r = roughnessOf(q), steep = (1 + std::abs(std::log(1 - nh * nh + 1e-12)) / (r * r)) * 4 / r;
        for (int c = 0; c < 3; ++c) {
            const double size = d.value[c] + base.value[c]; // the base is taken with a share that is a difference
            ASSERT_NEAR(f.value[c], d.value[c], 1e-4 * size + 1e-9) << i;
            ASSERT_NEAR(f.sheenRoughness[c], d.sheenRoughness[c], 1e-4 * size * steep + 1e-7) << i;
            for (int k = 0; k < 3; ++k)
                ASSERT_NEAR(f.sheenColor[c][k], d.sheenColor[c][k], 2e-4 * (std::abs(d.sheenColor[c][k]) + 4 * base.value[c]) + 1e-9) << i;
        }
    }
}

TEST(Sheen, DerivativesAgreeWithCentralDifferences) {
    Library library;
    VelvetQueries generate{QueryGenerator(84, 2e-2)};
    int compared = 0;
    for (int i = 0; i < 10000; ++i) {
        const Query q = generate();
        const Library::Surface s = surfaceOf(q);
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        Library::BsdfDerivatives d;
        const glm::dvec3 value = library.bsdfCosDerivatives(s, n, wo, wi, d), base = evaluateDouble(withoutSheen(q)).value;
        if (value == glm::dvec3(0))
            continue;
        const double no = std::abs(glm::dot(n, wo)), ni = std::abs(glm::dot(n, wi)), r = q.sheenRoughness;
        const double eo = library.sheenAlbedo(no, roughnessOf(q)).value, ei = library.sheenAlbedo(ni, roughnessOf(q)).value, m = largest(s.sheenColor);
        // Away from the kinks: where the base is all taken, where both albedos are alike, where two colours are.
        if (std::abs(1 - m * std::max(eo, ei)) < 0.02 || std::abs(eo - ei) < 0.02 * std::max(eo, ei) || std::abs(no - 0.5) < 0.01 || std::abs(ni - 0.5) < 0.01)
            continue;
        ++compared;
        const SurfaceDifferences differences{library, s, n, wo, wi};
        const glm::dvec3 byColour = differences.by([](auto& t, double h) { t.baseColor += h; }, 0.1), byMetallic = differences.by([](auto& t, double h) { t.metallic += h; }, 0.01);
        const glm::dvec3 byRoughness = differences.by([](auto& t, double h) { t.lobe[kRoughness] += h; }, 3e-4 * roughnessOf(q));
        const double alpha = std::min(std::max(double(q.roughness) * q.roughness, 1e-3), roughnessOf(q) * roughnessOf(q)), step = std::min({alpha, no, ni});
        const glm::dvec3 h = glm::normalize(wo + wi);
        const double steep = 1 / r * (1 + std::abs(std::log(1 - glm::dot(n, h) * glm::dot(n, h) + 1e-12)) / (r * r));
        for (int c = 0; c < 3; ++c) {
            const double size = value[c] + base[c];
            ASSERT_NEAR(d.at[kAtBaseColor][c], byColour[c], 1e-8 * (size + std::abs(byColour[c]))) << i;
            ASSERT_NEAR(d.at[kAtMetallic][c], byMetallic[c], 1e-8 * (size + std::abs(byMetallic[c]))) << i;
            if (std::abs(r - kFloor) > 0.001) {
                ASSERT_NEAR(d.at[kAtSheenRoughness][c], byRoughness[c], 1e-6 * (std::abs(byRoughness[c]) + size * (r > kFloor ? steep : 1) + 1e-9)) << i;
            }
        }
        differences.expectNormal(d, step, value + base, 4e-6, i);
        // Each channel by each component of the colour.
        for (int k = 0; k < 3; ++k) {
            bool alike = false;
            for (int other = 0; other < 3; ++other)
                alike |= other != k && std::abs(s.sheenColor[k] - s.sheenColor[other]) < 1e-3;
            if (alike)
                continue;
            const glm::dvec3 finite = differences.by([k](auto& t, double by) { t.sheenColor[k] += by; }, 2e-4);
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(d.at[kAtSheenColor + std::uint32_t(k)][c], finite[c], 1e-8 * (value[c] + base[c] + std::abs(finite[c]))) << i << " component " << k;
        }
    }
    EXPECT_GT(compared, 5000);
}

// Of a grey one each channel counts for a third of what the base loses, so that all together say what the grey does.
TEST(Sheen, DerivativesOfGreyAddUp) {
    Library library;
    VelvetQueries generate{QueryGenerator(85, 2e-2)};
    for (int i = 0; i < 2000; ++i) {
        Query q = generate();
        q.sheenColor = glm::vec3(0.4f);
        const Library::Surface s = surfaceOf(q);
        const glm::dvec3 n = glm::normalize(glm::dvec3(q.normal)), wo = glm::normalize(glm::dvec3(q.wo)), wi = glm::normalize(glm::dvec3(q.wi));
        Library::BsdfDerivatives d;
        const glm::dvec3 value = library.bsdfCosDerivatives(s, n, wo, wi, d), base = evaluateDouble(withoutSheen(q)).value;
        const glm::dvec3 sum = d.at[kAtSheenColor] + d.at[kAtSheenColor + 1] + d.at[kAtSheenColor + 2];
        const glm::dvec3 finite = SurfaceDifferences{library, s, n, wo, wi}.by([](auto& t, double h) { t.sheenColor += h; }, 1e-5);
        const double e = std::max(library.sheenAlbedo(std::abs(glm::dot(n, wo)), roughnessOf(q)).value, library.sheenAlbedo(std::abs(glm::dot(n, wi)), roughnessOf(q)).value);
        if (std::abs(1 - 0.4 * e) < 0.01)
            continue;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(sum[c], finite[c], 1e-8 * (value[c] + base[c] + std::abs(finite[c]))) << i;
    }
}

Query velvet(float metallic, float white, float color, float roughness, float cosine) {
    Query q;
    q.baseColor = glm::vec3(white);
    q.roughness = 0.6f;
    q.metallic = metallic;
    q.specular = 0;
    q.sheenColor = glm::vec3(color);
    q.sheenRoughness = roughness;
    q.model = gpu::kMaterialSheen;
    q.wo = {std::sqrt(1 - cosine * cosine), 0, cosine};
    return q;
}

// 24 cases at a level of 1 % together (Bonferroni), the seeds fixed.
TEST(Sheen, DirectionsFollowTheirDensity) {
    int cases = 0;
    for (const float metallic : {0.0f, 1.0f})
        for (const auto& [color, roughness] : {std::pair(1.0f, 0.1f), std::pair(0.5f, 0.4f), std::pair(0.0f, 0.3f), std::pair(1.0f, 1.0f)})
            for (const float cosine : {1.0f, 0.6f, 0.1f}) {
                const Query q = velvet(metallic, 0.6f, color, roughness, cosine);
                double integral = 0;
                const HemisphereMesh mesh({-q.wo.x, -q.wo.y, q.wo.z}, 0.1, 0.1 * cosine);
                const double significance = significanceOfDirections(q, mesh, std::uint32_t(900 + cases++), integral);
                ASSERT_LE(integral, 1 + 1e-4);
                EXPECT_GE(significance, 0.01 / 24) << "metallic " << metallic << " sheen " << color << ", " << roughness << " cosine " << cosine;
            }
    EXPECT_EQ(cases, 24);
}

// Where nothing but cosines is drawn from, no direction ends below the surface.
TEST(Sheen, DensityIntegratesToOne) {
    for (const float cosine : {1.0f, 0.3f, 0.05f})
        for (const float roughness : {0.1f, 0.5f}) {
            const Query q = velvet(0, 0.6f, 0.8f, roughness, cosine);
            Library library;
            Library::Surface s = surfaceOf(q);
            s.asked = 0;
            const HemisphereMesh mesh({q.wo.x, q.wo.y, 0.1}, 0.1, 0.1);
            const std::vector<double> parts = mesh.integrate([&](const glm::dvec3& wi) { return library.bsdfPdf(s, glm::dvec3(q.normal), glm::dvec3(q.wo), wi); });
            EXPECT_NEAR(std::accumulate(parts.begin(), parts.end(), 0.0), 1, 1e-5) << "roughness " << roughness << " cosine " << cosine;
        }
}

// Under a uniform sky, over a white diffuse base, what comes back is E(n.wo) and the mean of what is left for the base, by integrals of the extension's formula.
// From a roughness of 0.3 it is at most what arrives; below, the extension's own E is above 1 at grazing angles.
TEST(Sheen, ReflectsAtMostWhatArrives) {
    constexpr int kSteps = 128; // of the square of the cosine
    for (const float roughness : {0.1f, 0.3f, 0.5f, 1.0f}) {
        std::array<double, kSteps> albedo;
        for (int k = 0; k < kSteps; ++k)
            albedo[std::size_t(k)] = albedoByIntegration(std::sqrt((k + 0.5) / kSteps), roughness);
        for (const float color : {0.3f, 1.0f})
            for (const float cosine : {1.0f, 0.5f, 0.2f, 0.1f, 0.03f}) {
                Query q = velvet(0, 1, color, roughness, cosine);
                const double finest = std::min(0.05, 0.3 * roughness * roughness);
                const HemisphereMesh mesh({q.wo.x, q.wo.y, 1e-6}, finest, finest);
                const std::vector<double> parts = mesh.integrate([&](const glm::dvec3& wi) {
                    q.wi = glm::vec3(wi);
                    return evaluateDouble(q).value.x;
                });
                const double reflected = std::accumulate(parts.begin(), parts.end(), 0.0), e = albedoByIntegration(cosine, roughness);
                double left = 0; // for the base
                for (const double a : albedo)
                    left += std::max(1 - color * std::max(e, a), 0.0) / kSteps;
                EXPECT_NEAR(reflected, color * e + left, 0.005) << "roughness " << roughness << " colour " << color << " cosine " << cosine;
                if (roughness >= 0.3f) {
                    EXPECT_LE(reflected, 1.004) << "roughness " << roughness << " colour " << color << " cosine " << cosine;
                }
            }
    }
}

} // namespace
} // namespace cmpg::test
