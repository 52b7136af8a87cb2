// Texture look-ups against filtering done by hand.
#include "shader_float.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;
using Weights = Library::TexelWeights;

int wrapped(int i, int size, std::uint32_t wrap) {
    if (wrap == 1) return std::min(std::max(i, 0), size - 1);
    const int period = wrap == 0 ? size : 2 * size;
    i = ((i % period) + period) % period;
    return wrap == 2 && i >= size ? period - 1 - i : i;
}

// Bilinear filtering of an endless wrapped grid in long double: the value of a grid of random numbers.
double reference(const std::vector<double>& grid, int width, int height, double u, double v, std::uint32_t wrapU, std::uint32_t wrapV, bool nearest) {
    const double x = u * width - (nearest ? 0 : 0.5), y = v * height - (nearest ? 0 : 0.5);
    const int i = int(std::floor(x)), j = int(std::floor(y));
    const auto at = [&](int a, int b) { return grid[std::size_t(wrapped(b, height, wrapV)) * width + wrapped(a, width, wrapU)]; };
    if (nearest) return at(i, j);
    const double fx = x - i, fy = y - j;
    return (at(i, j) * (1 - fx) + at(i + 1, j) * fx) * (1 - fy) + (at(i, j + 1) * (1 - fx) + at(i + 1, j + 1) * fx) * fy;
}

double filter(const std::vector<double>& grid, const Weights& t) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) sum += grid[t.index[k]] * double(t.weight[k]);
    return sum;
}

void expectSane(const Weights& t, std::uint32_t texels) {
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        ASSERT_LT(t.index[k], texels);
        ASSERT_GE(t.weight[k], 0);
        sum += double(t.weight[k]);
    }
    ASSERT_NEAR(sum, 1, 1e-6);
}

TEST(Texel, AgreesWithFilteringByHand) {
    Library library;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 3), std::pair(7, 5), std::pair(64, 1)}) {
        std::vector<double> grid(std::size_t(width) * height);
        for (double& g : grid) g = uniform(random);
        for (std::uint32_t wrapU = 0; wrapU < 3; ++wrapU) {
            for (std::uint32_t wrapV = 0; wrapV < 3; ++wrapV) {
                for (const bool nearest : {false, true}) {
                    for (int i = 0; i < 2000; ++i) {
                        const float u = float(6 * uniform(random) - 3), v = float(6 * uniform(random) - 3);
                        const Weights t = library.texelWeights({u, v}, width, height, wrapU, wrapV, nearest);
                        expectSane(t, width * height);
                        // Beside a texel's edge float may pick the other nearest texel.
                        const auto nearEdge = [](double x) { return std::abs(x - std::round(x)) < 1e-4; };
                        if (nearest && (nearEdge(double(u) * width) || nearEdge(double(v) * height))) continue;
                        ASSERT_NEAR(filter(grid, t), reference(grid, width, height, u, v, wrapU, wrapV, nearest), 1e-4)
                            << u << ' ' << v << " of " << width << 'x' << height << " wrap " << wrapU << wrapV << " nearest " << nearest;
                    }
                }
            }
        }
    }
}

TEST(Texel, NearestReadsOneTexel) {
    Library library;
    const Weights t = library.texelWeights({0.3, 0.9}, 4, 4, 0, 0, true);
    EXPECT_EQ(t.index, glm::uvec4(13)); // row 3, column 1: row 0 is the top
    EXPECT_EQ(t.weight, glm::vec4(1, 0, 0, 0));
}

TEST(Texel, StaysInsideForAnyNumber) {
    Library library;
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const float u : {nan, inf, -inf, 3e38f, -3e38f, -1e-30f, -1e-9f, 0.0f, 1.0f, 0.99999994f, 1.0000001f, 2.0f, -1.0f, 1e7f, 123456.78f}) {
        for (std::uint32_t wrap = 0; wrap < 3; ++wrap) {
            for (const bool nearest : {false, true}) expectSane(library.texelWeights({u, u}, 5, 3, wrap, wrap, nearest), 15);
        }
        if (std::isfinite(u)) expectSane(library.environmentTexelWeights({u, u}, 5, 3), 15);
    }
}

TEST(Texel, EnvironmentRowsSitAtThePoles) {
    Library library;
    EXPECT_EQ(library.environmentTexelWeights({0.125, 0.0}, 4, 3).weight, glm::vec4(1, 0, 0, 0)); // centre of column 0, row 0
    EXPECT_EQ(library.environmentTexelWeights({0.125, 0.0}, 4, 3).index.x, 0u);
    const Weights bottom = library.environmentTexelWeights({0.125, 1.0}, 4, 3);
    EXPECT_EQ(bottom.index.z, 8u);
    EXPECT_EQ(bottom.weight, glm::vec4(0, 0, 1, 0));
    const Weights seam = library.environmentTexelWeights({0.0, 0.25}, 4, 3); // between the last and the first column, rows 0 and 1
    EXPECT_EQ(seam.index, glm::uvec4(3, 0, 7, 4));
    EXPECT_EQ(seam.weight, glm::vec4(0.25));
    expectSane(library.environmentTexelWeights({0.5, 0.5}, 3, 1), 3); // a single row
}

} // namespace
} // namespace cmpg::test
