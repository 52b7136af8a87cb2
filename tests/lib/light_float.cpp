// Light falloff and sampling heuristics in the float build.
#include "shader_float.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;

TEST(Light, FallsOffAsTheExtensionSays) {
    Library library;
    EXPECT_FLOAT_EQ(library.distanceFalloff(4, 0), 0.25);
    EXPECT_FLOAT_EQ(library.distanceFalloff(4, 4), 0.25f * (1 - 1.0f / 16));
    EXPECT_EQ(library.distanceFalloff(16, 4), 0);
    EXPECT_EQ(library.distanceFalloff(100, 4), 0);
    EXPECT_EQ(library.distanceFalloff(0, 4), 0);
    const float inner = 0.9, outer = 0.5;
    EXPECT_EQ(library.spotFalloff(0.95, inner, outer), 1);
    EXPECT_EQ(library.spotFalloff(0.4, inner, outer), 0);
    EXPECT_NEAR(library.spotFalloff(0.7, inner, outer), 0.25, 1e-6);
    EXPECT_TRUE(std::isfinite(library.spotFalloff(0.5, 0.5, 0.5)));
    EXPECT_FLOAT_EQ(library.areaToSolidAngle(0.5, 9, 0.25), 18);
    EXPECT_EQ(library.areaToSolidAngle(0.5, 9, -0.25), 0);
}

TEST(Mis, WeightsAddUpToOne) {
    Library library;
    const float inf = std::numeric_limits<float>::infinity();
    for (const float a : {0.0f, 1e-38f, 1e-20f, 0.3f, 1.0f, 1e20f, 3e38f, inf}) {
        for (const float b : {0.0f, 1e-38f, 1e-20f, 0.3f, 1.0f, 1e20f, 3e38f, inf}) {
            const float sum = library.misWeight(a, b) + library.misWeight(b, a);
            EXPECT_NEAR(sum, a == 0 && b == 0 ? 0 : 1, 1e-6) << a << ' ' << b;
        }
    }
    EXPECT_FLOAT_EQ(library.misWeight(3, 1), 0.9);
}

} // namespace
} // namespace cmpg::test
