// Normals of a normal map that turn from the eye.
#include "central_difference.h"
#include "shader_double.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

using shader_double::kAtNormal;
using Library = shader_double::ShaderLibrary;

struct Case {
    glm::dvec3 own, mapped, wo;
};

// The surface's own normal may be behind, and half of the mapped ones turn from wo.
struct Cases {
    std::mt19937 random{7};
    glm::dvec3 direction() {
        std::normal_distribution<double> normal;
        return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    }
    Case operator()() {
        Case c{direction(), {}, direction()};
        c.mapped = glm::normalize(c.own + 1.5 * direction());
        return c;
    }
};

TEST(MappedNormals, EyeSeesThem) {
    Library library;
    const double least = library.kLeastMappedCosine;
    Cases next;
    int turned = 0;
    for (int i = 0; i < 10000; ++i) {
        const Case c = next();
        const double side = glm::dot(c.own, c.wo) < 0 ? -1 : 1;
        const glm::dvec3 n = library.visibleNormal(c.own, c.mapped, c.wo);
        ASSERT_NEAR(glm::length(n), 1, 1e-12);
        ASSERT_GE(side * glm::dot(n, c.wo), least / std::hypot(1, least) - 1e-12) << i;
        if (side * glm::dot(c.mapped, c.wo) >= least) {
            ASSERT_EQ(n, c.mapped) << i;
            continue;
        }
        ++turned;
        // Tilted in the plane of both, no farther than it takes.
        ASSERT_NEAR(glm::dot(n, glm::cross(c.mapped, c.wo)), 0, 1e-12) << i;
        ASSERT_LE(side * glm::dot(n, c.wo), 1.0000001 * least / std::sqrt(1 - std::pow(glm::dot(c.mapped, c.wo), 2))) << i;
    }
    EXPECT_GT(turned, 2000);
}

TEST(MappedNormals, TurnWithoutAJump) {
    Library library;
    for (const double across : {0.0, 1.0, 2.5}) {
        const glm::dvec3 own(0, 0, 1), wo = glm::normalize(glm::dvec3(1, 0, 0.3));
        const auto at = [&](double cosine) {
            const glm::dvec3 aside = glm::normalize(own - wo * glm::dot(own, wo)), third = glm::cross(aside, wo);
            return cosine * wo + std::sqrt(1 - cosine * cosine) * (std::cos(across) * aside + std::sin(across) * third);
        };
        const double edge = library.kLeastMappedCosine;
        EXPECT_LE(glm::distance(library.visibleNormal(own, at(edge + 1e-9), wo), library.visibleNormal(own, at(edge - 1e-9), wo)), 1e-8);
        EXPECT_LE(glm::distance(library.visibleNormal(own, at(1e-9), wo), library.visibleNormal(own, at(-1e-9), wo)), 1e-8);
    }
}

// What is scattered, by the mapped normal, against differences.
TEST(MappedNormals, DerivativesMatchDifferences) {
    Library library;
    Library::Surface surface;
    surface.baseColor = {0.8, 0.5, 0.2};
    surface.roughness = 0.6;
    surface.metallic = 0.3;
    surface.specular = 1;
    surface.specularColor = glm::dvec3(1);
    surface.ior = 1.5;
    surface.asked = ~0u;
    surface.model = gpu::kModelMetallicRoughness << gpu::kModelShift;
    Cases next;
    int turned = 0;
    for (int i = 0; i < 4000; ++i) {
        const Case c = next();
        const double side = glm::dot(c.own, c.wo) < 0 ? -1 : 1, cosine = side * glm::dot(c.mapped, c.wo);
        // Not across the edge, nor where the tilted normal turns much faster than the mapped one.
        if (std::abs(cosine - library.kLeastMappedCosine) < 0.01 || cosine < -0.8)
            continue;
        const auto value = [&](const glm::dvec3& mapped, const glm::dvec3& wi) {
            return library.bsdfCos(surface, library.visibleNormal(c.own, glm::normalize(mapped), c.wo), c.wo, wi);
        };
        const glm::dvec3 n = library.visibleNormal(c.own, c.mapped, c.wo), wi = glm::normalize(side * n + 0.7 * next.direction());
        Library::BsdfDerivatives d;
        library.bsdfCosDerivatives(surface, n, c.wo, wi, d);
        library.fromVisibleNormal(c.own, c.mapped, c.wo, d);
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 direction(0);
            direction[axis] = 1;
            direction -= c.mapped * c.mapped[axis]; // the rest of it changes the length alone
            const glm::dvec3 finite = difference([&](double h) { return value(c.mapped + h * direction, wi); }, 1e-4);
            glm::dvec3 found(0);
            for (int k = 0; k < 3; ++k)
                found += d.at[kAtNormal + k] * direction[k];
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(found[channel], finite[channel], 1e-5 * (1 + std::abs(found[channel]))) << i << " axis " << axis;
        }
        turned += cosine < 0;
    }
    EXPECT_GT(turned, 500);
}

} // namespace
} // namespace cmpg::test
