// What untold texels are guessed to be: patterns go on, and smooth textures are left to smooth surfaces.
#include "optimize/fourier.h"
#include "optimize/texture_guess.h"

#include <cmath>
#include <complex>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace cmpg {
namespace {

constexpr TextureGrid kGrid{48, 48, 3};

std::vector<float> textureOf(const TextureGrid& grid, const std::function<float(std::size_t x, std::size_t y, std::size_t c)>& value) {
    std::vector<float> values;
    for (std::size_t y = 0; y < grid.height; ++y)
        for (std::size_t x = 0; x < grid.width; ++x)
            for (std::size_t c = 0; c < grid.channels; ++c)
                values.push_back(value(x, y, c));
    return values;
}

// Bricks of 12 x 6 texels, every other row half a brick aside.
float brick(std::size_t x, std::size_t y, std::size_t c) {
    const bool mortar = y % 6 == 0 || (x + y / 6 % 2 * 6) % 12 == 0;
    return (mortar ? 0.8f : 0.3f) + 0.1f * float(c);
}

// All but a disc of a third of the texture.
std::vector<bool> disc(const TextureGrid& grid) {
    std::vector<bool> told;
    for (std::size_t t = 0; t < grid.width * grid.height; ++t) {
        const double x = (double(t % grid.width) + 0.5) / double(grid.width) - 0.5, y = (double(t / grid.width) + 0.5) / double(grid.height) - 0.5;
        told.push_back(x * x + y * y > 1 / (3 * std::numbers::pi));
    }
    return told;
}

// Of the untold texels.
double meanSquare(const std::vector<float>& a, const std::vector<float>& b, const std::vector<bool>& told, std::size_t channels) {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        if (!told[i / channels]) {
            sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
            ++count;
        }
    return sum / count;
}

// Told texels with noise, and 0.5 where nothing is told.
std::vector<float> seenOf(const std::vector<float>& truth, const std::vector<bool>& told, std::size_t channels) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal(0, 0.02f);
    std::vector<float> values = truth;
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = told[i / channels] ? values[i] + normal(random) : 0.5f;
    return values;
}

TEST(Fourier, TransformIsItsDefinitionAndTheInverseBringsItBack) {
    constexpr std::size_t kWidth = 8, kHeight = 4;
    FourierPlane plane(kWidth, kHeight);
    std::mt19937 random(1);
    std::normal_distribution<float> normal;
    for (std::size_t i = 0; i < plane.real.size(); ++i) {
        plane.real[i] = normal(random);
        plane.imaginary[i] = normal(random);
    }
    const FourierPlane before = plane;
    plane.transform();
    ASSERT_EQ(plane.width(), kHeight);
    for (std::size_t u = 0; u < kWidth; ++u)
        for (std::size_t v = 0; v < kHeight; ++v) {
            std::complex<double> sum;
            for (std::size_t y = 0; y < kHeight; ++y)
                for (std::size_t x = 0; x < kWidth; ++x)
                    sum += std::complex<double>(before.real[y * kWidth + x], before.imaginary[y * kWidth + x]) *
                           std::polar(1.0, -2 * std::numbers::pi * (double(u * x) / kWidth + double(v * y) / kHeight));
            EXPECT_NEAR(plane.real[u * kHeight + v], sum.real(), 1e-5);
            EXPECT_NEAR(plane.imaginary[u * kHeight + v], sum.imag(), 1e-5);
        }
    plane.invert();
    ASSERT_EQ(plane.width(), kWidth);
    for (std::size_t i = 0; i < plane.real.size(); ++i) {
        EXPECT_NEAR(plane.real[i] / (kWidth * kHeight), before.real[i], 1e-6);
        EXPECT_NEAR(plane.imaginary[i] / (kWidth * kHeight), before.imaginary[i], 1e-6);
    }
}

TEST(TextureGuess, PatternsGoOn) {
    for (const TextureGrid& grid : {kGrid, TextureGrid{64, 32, 1}, TextureGrid{40, 56, 4}}) {
        SCOPED_TRACE(testing::Message() << grid.width << " x " << grid.height);
        const std::vector<float> truth = textureOf(grid, brick);
        const std::vector<bool> told = disc(grid);
        const std::optional<std::vector<float>> guess = guessTexture(grid, seenOf(truth, told, grid.channels), told);
        ASSERT_TRUE(guess);
        EXPECT_LT(meanSquare(*guess, truth, told, grid.channels), 0.01); // of bricks' variance of 0.05
        EXPECT_EQ(guess, guessTexture(grid, seenOf(truth, told, grid.channels), told));
    }
}

// What the texels were before they are told makes no difference.
TEST(TextureGuess, DependsOnWhatIsToldAlone) {
    const std::vector<bool> told = disc(kGrid);
    std::vector<float> values = seenOf(textureOf(kGrid, brick), told, 3);
    const std::optional<std::vector<float>> guess = guessTexture(kGrid, values, told);
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!told[i / 3])
            values[i] = 0.9f;
    EXPECT_EQ(guess, guessTexture(kGrid, values, told));
}

TEST(TextureGuess, LargeTexturesAreGuessedFromACoarserGrid) {
    const TextureGrid grid{192, 192, 3};
    const std::vector<float> truth = textureOf(grid, [](std::size_t x, std::size_t y, std::size_t c) { return brick(x / 4, y / 4, c); });
    const std::vector<bool> told = disc(grid);
    const std::optional<std::vector<float>> guess = guessTexture(grid, seenOf(truth, told, 3), told);
    ASSERT_TRUE(guess);
    EXPECT_LT(meanSquare(*guess, truth, told, 3), 0.02);
}

TEST(TextureGuess, SmoothTexturesAreNotGuessed) {
    const std::vector<bool> told = disc(kGrid);
    const auto guess = [&](const std::vector<float>& truth) { return guessTexture(kGrid, seenOf(truth, told, 3), told); };
    EXPECT_FALSE(guess(textureOf(kGrid, [](std::size_t x, std::size_t y, std::size_t) { return float(x) / 60 + float(y) / 200; })));
    EXPECT_FALSE(guess(textureOf(kGrid, [](std::size_t x, std::size_t, std::size_t) { return x < 20 ? 0.2f : 0.8f; })));
    EXPECT_FALSE(guess(textureOf(kGrid, [](std::size_t, std::size_t, std::size_t) { return 0.5f; })));
}

TEST(TextureGuess, NeedsToldAndUntoldTexels) {
    const std::vector<float> truth = textureOf(kGrid, brick);
    EXPECT_FALSE(guessTexture(kGrid, truth, std::vector<bool>(48 * 48, true)));
    EXPECT_FALSE(guessTexture(kGrid, truth, std::vector<bool>(48 * 48, false)));
    std::vector<bool> few(48 * 48, false);
    std::fill_n(few.begin(), 200, true);
    EXPECT_FALSE(guessTexture(kGrid, truth, few));
    EXPECT_FALSE(guessTexture({4, 4, 3}, std::vector<float>(48, 0.5f), std::vector<bool>(16, true)));
}

} // namespace
} // namespace cmpg
