// Weights of pixels by the noise of the image around them.
#include "optimize/noise_weights.h"

#include "optimize/losses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cmpg {
namespace {

constexpr int kSize = 32;

// Halves that differ by twice `deviation` everywhere, so that this is the standard deviation of their mean.
std::array<Image, 2> halvesOf(float deviation) { return {Image(kSize, kSize, 3, 0.5f + deviation), Image(kSize, kSize, 3, 0.5f - deviation)}; }

void makeNoisy(std::array<Image, 2>& halves, int x, int y, float deviation) {
    for (int c = 0; c < 3; ++c) {
        halves[0].at(x, y)[c] = 0.5f + deviation;
        halves[1].at(x, y)[c] = 0.5f - deviation;
    }
}

// The weights, as an adjoint of ones shows them.
Image weights(const std::array<Image, 2>& halves, double value, const Target& target, Loss loss = Loss::Mse) {
    Image adjoint(kSize, kSize, 3, 1.f);
    weigh(adjoint, noiseWeights(loss, halves, target, value));
    return adjoint;
}

Target grey() {
    Target target;
    target.image = Image(kSize, kSize, 3, 0.5f);
    return target;
}

TEST(NoiseWeights, AreEqualWhereNoiseIs) {
    for (const float weight : weights(halvesOf(0.1f), 0, grey()).values)
        EXPECT_NEAR(weight, 0.5, 1e-6);
    for (const float weight : weights(halvesOf(0.1f), 0.03, grey()).values) // s is 0.01 + 0.03
        EXPECT_NEAR(weight, 0.8, 1e-6);
    for (const float weight : weights(halvesOf(0), 0, grey()).values)
        EXPECT_EQ(weight, 1);
}

TEST(NoiseWeights, AreSmallWhereAnImageIsNoisy) {
    std::array<Image, 2> halves = halvesOf(0.01f);
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x)
            makeNoisy(halves, x, y, 1);
    const Image found = weights(halves, 0, grey());
    const double mean = (64 + (kSize * kSize - 64) * 1e-4) / (kSize * kSize);
    EXPECT_NEAR(found.at(2, 3)[0], mean / (mean + 1), 1e-6);
    EXPECT_NEAR(found.at(20, 20)[1], mean / (mean + 1e-4), 1e-6);
}

TEST(NoiseWeights, DoNotLookAtThePixelItself) {
    std::array<Image, 2> halves = halvesOf(0.1f);
    makeNoisy(halves, 16, 16, 4);
    const Image found = weights(halves, 0, grey());
    const double mean = 0.01 + (16 - 0.01) / (kSize * kSize), around = 0.1 + (4 - 0.1) / 48;
    EXPECT_NEAR(found.at(16, 16)[0], mean / (mean + 0.01), 1e-6);
    EXPECT_NEAR(found.at(17, 16)[0], mean / (mean + around * around), 1e-6);
    EXPECT_NEAR(found.at(20, 16)[0], mean / (mean + 0.01), 1e-6); // beyond its reach
}

TEST(NoiseWeights, LeaveOutWhatIsMaskedOrNotFinite) {
    std::array<Image, 2> halves = halvesOf(0.1f);
    Target target = grey();
    target.mask.assign(kSize * kSize, 1);
    for (int x = 0; x < kSize; ++x) {
        makeNoisy(halves, x, 10, 100);
        target.mask[std::size_t(10 * kSize + x)] = 0;
        halves[0].at(x, 20)[0] = std::numeric_limits<float>::infinity();
    }
    const Image found = weights(halves, 0, target);
    for (int x = 0; x < kSize; ++x) {
        EXPECT_NEAR(found.at(x, 11)[0], 0.5, 1e-6);
        EXPECT_NEAR(found.at(x, 21)[0], 0.5, 1e-6);
    }
}

TEST(NoiseWeights, MeasureNoiseInUnitsOfTheLoss) {
    std::array<Image, 2> halves = halvesOf(0.1f);
    Target target = grey();
    for (int y = 0; y < kSize; ++y) // bright and noisy to the same part
        for (int x = kSize / 2; x < kSize; ++x) {
            makeNoisy(halves, x, y, float(0.1 * std::sqrt((100 + kLossEpsilon) / (0.25 + kLossEpsilon))));
            for (int c = 0; c < 3; ++c)
                target.image.at(x, y)[c] = 10;
        }
    for (const float weight : weights(halves, 0, target, Loss::RelativeMse).values)
        EXPECT_NEAR(weight, 0.5, 1e-5);
}

} // namespace
} // namespace cmpg
