// Which pixels get the samples of an image.
#include "optimize/pixel_shares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace cmpg {
namespace {

constexpr int kSize = 32;

// Of images that answer by 1 in the left half, where a path finds the light with probability `chance` and carries 1 / chance then.
std::vector<float> sharesOf(double chance, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::bernoulli_distribution found(chance);
    const auto half = [&] {
        Image image(kSize, kSize, 3, 0);
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize / 2; ++x)
                if (found(random))
                    std::fill_n(image.at(x, y), 3, float(1 / chance));
        return image;
    };
    PixelAnswers answers;
    answers.add(half(), half());
    return answers.shares(kSize, kSize);
}

float meanShare(const std::vector<float>& shares) { return std::accumulate(shares.begin(), shares.end(), 0.f) / float(shares.size()); }

TEST(PixelShares, WhatAnswersGetsTheSamples) {
    const std::vector<float> shares = sharesOf(1, 1);
    EXPECT_NEAR(meanShare(shares), 1, 1e-4);
    const float* row = shares.data() + std::size_t(kSize / 2) * kSize;
    for (int x = 1; x < kSize / 2 - 1; ++x)
        EXPECT_NEAR(row[x], row[kSize / 4], 1e-4);
    for (int x = kSize / 2 + 1; x < kSize; ++x)
        EXPECT_NEAR(row[x], 0, 1e-5);
}

// One path in twenty finds light: what two halves have in common is chance.
TEST(PixelShares, WhatIsNotKnownGetsAllPixelsAlike) {
    int some = 0;
    for (std::uint32_t seed = 0; seed < 10; ++seed) {
        const std::vector<float> shares = sharesOf(0.05, seed);
        if (shares.empty())
            continue;
        ++some;
        EXPECT_NEAR(meanShare(shares), 1, 1e-4);
        EXPECT_GT(*std::min_element(shares.begin(), shares.end()), 0.8);
    }
    EXPECT_GT(some, 3) << "seeds without anything in common test nothing";
}

TEST(PixelShares, NoAnswerIsNoShare) {
    const Image dark(kSize, kSize, 3, 0);
    PixelAnswers answers;
    answers.add(dark, dark);
    EXPECT_TRUE(answers.shares(kSize, kSize).empty());
}

// A mask leaves the upper half: it gets all samples, also those that go to all pixels alike.
TEST(PixelShares, MaskedPixelsGetNone) {
    std::vector<float> mask(kSize * kSize, 0.f);
    std::fill_n(mask.begin(), mask.size() / 2, 0.5f);
    Image a(kSize, kSize, 3, 1), b = a;
    for (int x = 0; x < kSize; ++x)
        std::fill_n(b.at(x, x), 3, -0.5f); // what halves do not agree on
    PixelAnswers answers;
    answers.add(a, b, mask);
    const std::vector<float> shares = answers.shares(kSize, kSize);
    ASSERT_EQ(shares.size(), mask.size());
    EXPECT_NEAR(meanShare(shares), 1, 1e-4);
    for (std::size_t p = 0; p < shares.size(); ++p)
        EXPECT_EQ(shares[p] > 0, mask[p] > 0) << p;
}

// Paths that overflowed say nothing, and the largest numbers that are left are finite shares.
TEST(PixelShares, SharesAreFinite) {
    Image image(kSize, kSize, 3, 1);
    image.at(3, 3)[0] = 1e30f;
    std::fill_n(image.at(9, 9), 3, 1e19f);
    std::fill_n(image.at(10, 9), 3, 1e19f);
    PixelAnswers answers;
    answers.add(image, image);
    for (const float share : answers.shares(kSize, kSize))
        EXPECT_TRUE(share >= 0 && share < 1e9f);
}

} // namespace
} // namespace cmpg
