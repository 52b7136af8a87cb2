// Pixel sampling: shares follow the adjoint, counts are unbiased and depend on (seed, step, pixel) alone.
#include "render/pixel_sampling.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace cmpg {
namespace {

// A ramp with both signs, so that a missing absolute value would show.
Image rampAdjoint(int size) {
    Image adjoint(size, size, 3);
    for (std::size_t i = 0; i < adjoint.values.size(); ++i) adjoint.values[i] = 1e-6f * (float(i % 97) - 48);
    return adjoint;
}

double expectedSamples(const Image& adjoint, std::size_t pixel, double spp) {
    double total = 0, own = 0;
    for (std::size_t i = 0; i < adjoint.values.size(); ++i) {
        const double magnitude = std::abs(double(adjoint.values[i])) / 3;
        total += magnitude;
        if (i / 3 == pixel) own += magnitude;
    }
    return spp * (0.2 + 0.8 * own * double(adjoint.pixels()) / total);
}

TEST(PixelSampling, WeightsAreOneOverTheExpectation) {
    const Image adjoint = rampAdjoint(16);
    const PixelSamples s = sampleCounts(adjoint, 4, {});
    double sum = 0;
    for (std::size_t p = 0; p < adjoint.pixels(); ++p) {
        const double expected = expectedSamples(adjoint, p, 4);
        EXPECT_NEAR(s.weights[p] * expected, 1, 1e-6) << "pixel " << p;
        EXPECT_LE(std::abs(double(s.counts[p]) - expected), 1) << "pixel " << p;
        sum += 1 / s.weights[p];
    }
    EXPECT_NEAR(sum / double(adjoint.pixels()), 4, 1e-5); // the shares average 1: spp is what is spent
}

TEST(PixelSampling, MeanOfCountsEqualsExpectation) {
    const Image adjoint = rampAdjoint(16);
    constexpr int kSteps = 4000;
    std::vector<double> sums(adjoint.pixels());
    for (int step = 0; step < kSteps; ++step) {
        const PixelSamples s = sampleCounts(adjoint, 2, {.seed = 7, .step = std::uint32_t(step), .pass = 1});
        for (std::size_t p = 0; p < sums.size(); ++p) sums[p] += s.counts[p];
    }
    // A rounded count is floor(e) or floor(e)+1: standard deviation sqrt(f(1-f)) <= 1/2. 5 standard errors over 256 pixels fail by
    // chance with probability 256 * 5.7e-7 = 1.5e-4.
    const double limit = 5 * 0.5 / std::sqrt(double(kSteps));
    for (std::size_t p = 0; p < sums.size(); ++p) EXPECT_NEAR(sums[p] / kSteps, expectedSamples(adjoint, p, 2), limit) << "pixel " << p;
}

TEST(PixelSampling, WholeExpectationsAreMetExactly) {
    const PixelSamples s = sampleCounts(Image(16, 16, 3, 1.0f), 5, {.seed = 1});
    for (std::uint32_t c : s.counts) EXPECT_EQ(c, 5u);
}

TEST(PixelSampling, NeighboursAndStepsAreIndependent) {
    Image adjoint(101, 101, 3); // odd, so that the pattern of two values shifts from row to row
    for (std::size_t p = 0; p < adjoint.pixels(); ++p)
        for (int c = 0; c < 3; ++c) adjoint.values[p * 3 + c] = p % 2 ? 0.375f : 1.625f; // expects 0.5 and 1.5 samples
    const PixelSamples a = sampleCounts(adjoint, 1, {.seed = 1, .step = 0, .pass = 1});
    const PixelSamples b = sampleCounts(adjoint, 1, {.seed = 1, .step = 1, .pass = 1});
    const auto centred = [](const PixelSamples& s, std::size_t p) { return double(s.counts[p]) - 1.0 / s.weights[p]; };
    double neighbours = 0, steps = 0;
    for (std::size_t p = 0; p + 1 < adjoint.pixels(); ++p) {
        neighbours += centred(a, p) * centred(a, p + 1);
        steps += centred(a, p) * centred(b, p);
    }
    const double limit = 5 * 0.25 * std::sqrt(double(adjoint.pixels())); // 5 standard deviations: each product has variance 1/16
    EXPECT_LT(std::abs(neighbours), limit);
    EXPECT_LT(std::abs(steps), limit);
}

TEST(PixelSampling, IsDeterministic) {
    const Image adjoint = rampAdjoint(32);
    const PassKey key{.seed = 3, .step = 5, .pass = 1};
    const PixelSamples a = sampleCounts(adjoint, 4, key), b = sampleCounts(adjoint, 4, key);
    EXPECT_EQ(a.counts, b.counts);
    EXPECT_EQ(a.weights, b.weights);
    EXPECT_NE(a.counts, sampleCounts(adjoint, 4, {.seed = 4, .step = 5, .pass = 1}).counts);
}

TEST(PixelSampling, ZeroAdjointIsUniform) {
    const PixelSamples s = sampleCounts(Image(8, 8, 3), 16, {});
    for (std::uint32_t c : s.counts) EXPECT_EQ(c, 16u);
}

TEST(PixelSampling, NonFiniteAdjointCountsAsZero) {
    Image adjoint(4, 4, 3, 1.0f);
    adjoint.values[5] = std::numeric_limits<float>::quiet_NaN(); // pixel 1
    const PixelSamples s = sampleCounts(adjoint, 10, {});
    EXPECT_NEAR(1 / s.weights[1], 2, 1e-5); // the floor of 0.2
    EXPECT_NEAR(1 / s.weights[0], 10 * (0.2 + 0.8 * 16.0 / 15), 1e-5);
}

} // namespace
} // namespace cmpg
