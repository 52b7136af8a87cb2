// Environment map directions and cells in the float build.
#include "shader_float.h"
#include "statistics.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;
const double kPi = std::acos(-1.0L);

glm::dvec3 randomDirection(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random), y = normal(random), z = normal(random);
    return glm::normalize(glm::dvec3(x, y, z));
}

TEST(Environment, MapsAsTheConventionSays) {
    Library library;
    const auto near = [](const glm::vec2& a, const glm::vec2& b) { return glm::length(a - b) < 1e-6f; };
    EXPECT_TRUE(near(library.environmentUv({0, 0, -1}), {0, 0.5}));
    EXPECT_TRUE(near(library.environmentUv({1, 0, 0}), {0.25, 0.5}));
    EXPECT_TRUE(near(library.environmentUv({0, 0, 1}), {0.5, 0.5}));
    EXPECT_TRUE(near(library.environmentUv({-1, 0, 0}), {0.75, 0.5}));
    EXPECT_NEAR(library.environmentUv({0, 1, 0}).y, 0, 1e-7);
    EXPECT_NEAR(library.environmentUv({0, -1, 0}).y, 1, 1e-6);
    EXPECT_NEAR(library.environmentUv({1e-5f, 1, 0}).y, 1e-5 / 3.14159265, 1e-11); // acos would give 0
    EXPECT_LT(glm::length(library.rotateY({0, 0, -1}, 0, 1) - glm::vec3(-1, 0, 0)), 1e-6f);

    std::mt19937 random(5);
    for (int i = 0; i < 10000; ++i) {
        const glm::vec3 d(randomDirection(random));
        ASSERT_LT(glm::length(library.environmentDirection(library.environmentUv(d)) - d), 2e-6f);
    }
}

glm::vec4 randomCorners(std::mt19937& random) {
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto one = [&] { return std::pow(uniform(random), 4.0f); };
    return {one(), one(), one(), one()};
}

// Densities of all cells, integrated over the sphere by the midpoint rule, are the probability that they are selected with.
TEST(Environment, CellDensitiesIntegrateToTheirProbability) {
    Library library;
    std::mt19937 random(4);
    for (const auto& [width, height] : {std::pair(4u, 3u), std::pair(16u, 9u), std::pair(64u, 32u)})
        for (std::uint32_t row = 0; row + 1 < height; ++row) {
            const glm::vec4 corners = library.environmentCellCorners(randomCorners(random));
            constexpr int kPoints = 64;
            const double area = 2 * kPi / width * kPi / (height - 1) / (kPoints * kPoints); // of longitude and polar angle
            double sum = 0;
            for (int i = 0; i < kPoints; ++i)
                for (int j = 0; j < kPoints; ++j) {
                    const glm::vec2 inside((float(i) + 0.5f) / kPoints, (float(j) + 0.5f) / kPoints);
                    float sine;
                    library.environmentPoint(0, row, inside.y, height, sine);
                    sum += double(library.environmentCellDensity(corners, inside, 0.3f, sine, width, height)) * double(sine) * area;
                }
            EXPECT_NEAR(sum, 0.3, 1e-5) << row << " of " << height;
        }
    EXPECT_EQ(library.environmentCellCorners({0, 0, 0, 0}), glm::vec4(1)); // a dark cell is even
}

// Samples of a cell have the density that is claimed: counts in 8 x 8 squares, against integrals of the bilinear function.
TEST(Environment, CellSamplesHaveTheirDensity) {
    Library library;
    std::mt19937 random(6);
    double least = 1;
    constexpr int kSquares = 8, kSamples = 200'000, kTrials = 10;
    for (int trial = 0; trial < kTrials; ++trial) {
        const glm::vec4 c = library.environmentCellCorners(trial == 0 ? glm::vec4(0, 0, 0, 1) : trial == 1 ? glm::vec4(1) : randomCorners(random));
        std::vector<double> observed(kSquares * kSquares), expected(kSquares * kSquares);
        for (int i = 0; i < kSamples; ++i) {
            const float u = float(random() >> 8) * 0x1p-24f, v = float(random() >> 8) * 0x1p-24f;
            const glm::vec2 p = library.sampleEnvironmentCell(c, {u, v});
            ASSERT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
            const int x = std::min(kSquares - 1, int(p.x * kSquares)), y = std::min(kSquares - 1, int(p.y * kSquares));
            ++observed[std::size_t(y * kSquares + x)];
        }
        for (int y = 0; y < kSquares; ++y)
            for (int x = 0; x < kSquares; ++x) { // the mean of a bilinear function is that at the middle
                const glm::dvec2 m((x + 0.5) / kSquares, (y + 0.5) / kSquares);
                const double value = glm::mix(glm::mix(double(c.x), double(c.y), m.x), glm::mix(double(c.z), double(c.w), m.x), m.y);
                expected[std::size_t(y * kSquares + x)] = kSamples * value / (kSquares * kSquares);
            }
        least = std::min(least, chiSquareSignificance(observed, expected));
    }
    EXPECT_GT(least, 1e-3 / kTrials);
}

// A point of a cell lies in that cell, wherever it is.
TEST(Environment, CellPointsStayInside) {
    Library library;
    std::mt19937 random(7);
    const std::uint32_t width = 16, height = 9;
    int outside = 0;
    for (int i = 0; i < 160'000; ++i) {
        const glm::uvec2 cell(random() % width, random() % (height - 1));
        const float x = float(random() >> 8) * 0x1p-24f, y = float(random() >> 8) * 0x1p-24f;
        const float across = (float(cell.x) + 0.5f + x) / float(width);
        float sine;
        const glm::vec3 d = library.environmentPoint(across >= 1 ? across - 1 : across, cell.y, y, height, sine);
        ASSERT_NEAR(glm::length(d), 1, 1e-6);
        ASSERT_NEAR(sine, std::hypot(d.x, d.z), 1e-6);
        outside += library.environmentCell(library.environmentUv(d), width, height) != cell;
    }
    EXPECT_LE(outside, 3); // by rounding at the edges
}

} // namespace
} // namespace cmpg::test
