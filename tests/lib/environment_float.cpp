// Environment map directions and cells in the float build.
#include "shader_float.h"

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

TEST(Environment, CellsCoverTheSphere) {
    Library library;
    for (const auto& [width, height] : {std::pair(4u, 2u), std::pair(16u, 9u), std::pair(2048u, 1024u)}) {
        double sum = 0;
        for (std::uint32_t row = 0; row + 1 < height; ++row) sum += double(width) * double(library.environmentCellSolidAngle(row, width, height));
        EXPECT_NEAR(sum, 4 * kPi, 1e-4);
    }
}

// A point of a cell lies in that cell, and they are uniform by solid angle: the mean height in each row is known.
TEST(Environment, CellSamplesStayInsideAndAreUniform) {
    Library library;
    std::mt19937 random(6);
    const std::uint32_t width = 16, height = 9;
    int outside = 0;
    for (std::uint32_t row = 0; row + 1 < height; ++row) {
        const double top = std::cos(kPi * row / (height - 1)), bottom = std::cos(kPi * (row + 1) / (height - 1));
        const int samples = 20000;
        double sum = 0;
        for (int i = 0; i < samples; ++i) {
            const float x = float(random() >> 8) * 0x1p-24, y = float(random() >> 8) * 0x1p-24;
            const glm::uvec2 cell(i % width, row);
            const glm::vec3 d = library.sampleEnvironmentCell(cell, width, height, {x, y});
            ASSERT_NEAR(glm::length(d), 1, 1e-6);
            outside += library.environmentCell(library.environmentUv(d), width, height) != cell;
            sum += double(d.y);
        }
        // Uniform between the two heights; 4 standard errors.
        EXPECT_NEAR(sum / samples, (top + bottom) / 2, 4 * (top - bottom) / std::sqrt(12.0 * samples)) << row;
    }
    EXPECT_LE(outside, 3); // of 160000, by rounding at the edges
}

} // namespace
} // namespace cmpg::test
