// Conversion to fixed point in the float build.
#include "shader_float.h"

#include <cmath>
#include <cstdint>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;

std::int64_t fixed(Library& library, float x, float scale, bool* fits = nullptr) {
    glm::uvec2 words;
    const bool ok = library.toFixedPoint(x, scale, words);
    if (fits) *fits = ok;
    return static_cast<std::int64_t>(std::uint64_t(words.y) << 32 | words.x);
}

TEST(FixedPoint, RoundsExactly) {
    Library library;
    std::mt19937 random(8);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int i = 0; i < 200000; ++i) {
        const int k = int(random() % 60);
        const float x = float(uniform(random) * std::pow(10, 20 * uniform(random))), scale = std::ldexp(1.0f, k);
        const double exact = std::ldexp(double(x), k);
        if (std::abs(exact) >= 0x1p62) continue;
        ASSERT_EQ(fixed(library, x, scale), std::int64_t(std::nearbyint(exact))) << x << " 2^" << k;
    }
    EXPECT_EQ(fixed(library, 0.5, 1), 0); // ties to even
    EXPECT_EQ(fixed(library, 1.5, 1), 2);
    EXPECT_EQ(fixed(library, -2.5, 1), -2);
    EXPECT_EQ(fixed(library, -4294967296.0, 1), -4294967296);
}

TEST(FixedPoint, SaturatesAndSaysSo) {
    Library library;
    bool fits = true;
    EXPECT_EQ(fixed(library, 1e30, 1, &fits), std::int64_t(1) << 62);
    EXPECT_FALSE(fits);
    EXPECT_EQ(fixed(library, -std::numeric_limits<float>::infinity(), 1, &fits), -(std::int64_t(1) << 62));
    EXPECT_FALSE(fits);
    EXPECT_EQ(fixed(library, std::numeric_limits<float>::quiet_NaN(), 1, &fits), 0);
    EXPECT_FALSE(fits);
    EXPECT_EQ(fixed(library, -1e-30, 1024, &fits), 0);
    EXPECT_TRUE(fits);
}

} // namespace
} // namespace cmpg::test
