// Samples per pixel: expectation, cost, unbiasedness and independence of the rounding. Seeds are fixed.
#include "render/pixel_sampling.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

// Spans five orders of magnitude, both signs, some zeros.
Image makeAdjoint(int width, int height) {
    Image adjoint(width, height, 3);
    std::mt19937 random(9);
    std::normal_distribution<float> normal;
    for (std::size_t p = 0; p < adjoint.pixels(); ++p)
        for (int c = 0; c < 3; ++c)
            adjoint.values[3 * p + c] = p % 7 == 0 ? 0.f : 1e-9f * normal(random) * std::exp(2 * normal(random));
    return adjoint;
}

std::vector<double> expectedCounts(const Image& adjoint, std::uint32_t spp) {
    std::vector<double> magnitude(adjoint.pixels());
    double total = 0;
    for (std::size_t p = 0; p < magnitude.size(); ++p) {
        for (int c = 0; c < 3; ++c)
            magnitude[p] += std::abs(double(adjoint.values[3 * p + c])) / 3;
        total += magnitude[p];
    }
    for (double& m : magnitude)
        m = spp * (0.2 + 0.8 * m / total * double(magnitude.size()));
    return magnitude;
}

TEST(PixelSampling, CountsHaveTheirExpectation) {
    const Image adjoint = makeAdjoint(8, 8);
    const int repeats = 4000;
    for (const std::uint32_t spp : {1u, 4u}) {
        const std::vector<double> expected = expectedCounts(adjoint, spp);
        std::vector<double> sum(64);
        for (int step = 0; step < repeats; ++step) {
            const PixelSamples samples = sampleCounts(adjoint, spp, {11, std::uint32_t(step), 1});
            for (std::size_t p = 0; p < 64; ++p) {
                ASSERT_LT(std::abs(samples.counts[p] - expected[p]), 1); // rounded up or down, nothing else
                ASSERT_NEAR(samples.weights[p] * expected[p], 1, 1e-6);
                sum[p] += samples.counts[p];
            }
        }
        for (std::size_t p = 0; p < 64; ++p) {
            const double fraction = expected[p] - std::floor(expected[p]);
            // z-test, 64 pixels, two values of spp: |z| > 4.5 anywhere has probability 128 x 6.8e-6 < 1e-3.
            const double deviation = std::sqrt(fraction * (1 - fraction) * repeats);
            EXPECT_LE(std::abs(sum[p] - expected[p] * repeats), 4.5 * deviation + 1e-6) << p;
        }
    }
}

TEST(PixelSampling, CostsWhatUniformSamplesCost) {
    const Image adjoint = makeAdjoint(256, 256);
    const PixelSamples samples = sampleCounts(adjoint, 4, {1, 2, 3});
    double total = 0;
    for (const std::uint32_t count : samples.counts)
        total += count;
    // Rounding adds at most a variance of 1/4 per pixel: a standard deviation of 128; 4.5 of them (confidence 1 - 7e-6).
    EXPECT_NEAR(total, 4.0 * 65536, 4.5 * 128);
    for (const float weight : samples.weights)
        ASSERT_LE(weight, 1 / (0.2 * 4) * 1.000001); // the floor bounds every weight
}

TEST(PixelSampling, WeightedSumsAreUnbiased) {
    // Estimate sum_p adjoint_p * f_p from noisy samples of f_p, many times.
    const Image adjoint = makeAdjoint(16, 16);
    double truth = 0;
    const auto f = [](std::size_t p) { return 1.0 + double(p % 5); };
    for (std::size_t p = 0; p < adjoint.pixels(); ++p)
        truth += adjoint.values[3 * p] * f(p);
    std::mt19937 random(10);
    std::normal_distribution<double> normal;
    const int repeats = 2000;
    double mean = 0, square = 0;
    for (int r = 0; r < repeats; ++r) {
        const PixelSamples samples = sampleCounts(adjoint, 1, {std::uint64_t(r), 0, 1});
        double estimate = 0;
        for (std::size_t p = 0; p < adjoint.pixels(); ++p)
            for (std::uint32_t s = 0; s < samples.counts[p]; ++s)
                estimate += double(samples.weights[p]) * adjoint.values[3 * p] * f(p) * (1 + 0.5 * normal(random));
        mean += estimate / repeats;
        square += estimate * estimate / repeats;
    }
    const double error = std::sqrt((square - mean * mean) / repeats);
    EXPECT_LE(std::abs(mean - truth), 4 * error); // confidence 1 - 6e-5
    EXPECT_LT(error, 0.05 * std::abs(truth) + 1e-8); // and the test has power
}

TEST(PixelSampling, RoundingIsIndependentOverPixelsStepsPassesAndSeeds) {
    // Every other pixel has no adjoint: its count is a coin that shows 1 with probability 0.2.
    Image adjoint(256, 256, 3, 0.f);
    for (std::size_t p = 0; p < adjoint.pixels(); p += 2)
        adjoint.values[3 * p] = 1;
    const auto bits = [&](const PassKey& key) {
        const PixelSamples samples = sampleCounts(adjoint, 1, key);
        std::vector<int> result;
        for (std::size_t p = 1; p < samples.counts.size(); p += 2)
            result.push_back(int(samples.counts[p]));
        return result;
    };
    const std::vector<int> base = bits({1, 1, 1});
    const double n = double(base.size()), share = 0.2;
    const auto correlate = [&](const std::vector<int>& a, const std::vector<int>& b, std::size_t shift) {
        double sum = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            sum += (a[i] - share) * (b[(i + shift) % b.size()] - share);
        return sum / (share * (1 - share)) / std::sqrt(n); // standard normal under independence
    };
    // Eight z-values at |z| < 4: confidence 1 - 5e-4.
    EXPECT_LT(std::abs(correlate(base, base, 1)), 4);
    EXPECT_LT(std::abs(correlate(base, base, 128)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({2, 1, 1}), 0)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({1, 2, 1}), 0)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({1, 1, 0}), 0)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({1, 1, 2}), 0)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({1, 2, 1}), 1)), 4);
    EXPECT_LT(std::abs(correlate(base, bits({1ull << 32, 1, 1}), 0)), 4);
    EXPECT_EQ(base, bits({1, 1, 1}));
}

TEST(PixelSampling, ZeroAdjointIsUniform) {
    const PixelSamples samples = sampleCounts(Image(5, 4, 3, 0.f), 7, {1, 2, 3});
    for (std::size_t p = 0; p < 20; ++p) {
        EXPECT_EQ(samples.counts[p], 7u);
        EXPECT_FLOAT_EQ(samples.weights[p], 1.f / 7);
    }
}

TEST(PixelSampling, NonFiniteAdjointsCountAsZero) {
    Image adjoint(8, 8, 3, 1.f), clean = adjoint;
    adjoint.values[3] = std::nanf("");
    adjoint.values[8] = INFINITY;
    std::fill_n(clean.values.begin() + 3, 6, 0.f);
    EXPECT_EQ(sampleCounts(adjoint, 4, {1, 1, 1}).counts, sampleCounts(clean, 4, {1, 1, 1}).counts);
    EXPECT_EQ(sampleCounts(adjoint, 4, {1, 1, 1}).weights, sampleCounts(clean, 4, {1, 1, 1}).weights);
}

} // namespace
} // namespace cmpg
