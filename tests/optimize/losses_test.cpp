// Losses against values by hand and adjoints against central differences.
#include "base/error.h"
#include "optimize/losses.h"
#include "optimize/ordered_sum.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

constexpr Loss kAll[] = {Loss::Mse, Loss::L1, Loss::Smape, Loss::RelativeMse};

struct Pair {
    Image image, target;
    std::vector<float> mask;
};

Pair makePair() {
    Pair pair{Image(7, 5, 3), Image(7, 5, 3), std::vector<float>(35)};
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 2);
    for (float& v : pair.image.values)
        v = uniform(random);
    for (float& v : pair.target.values)
        v = uniform(random);
    for (std::size_t p = 0; p < pair.mask.size(); ++p)
        pair.mask[p] = p % 4 == 0 ? 0.f : uniform(random) / 2;
    return pair;
}

TEST(Losses, ValuesByHand) {
    EXPECT_DOUBLE_EQ(lossTerm(Loss::Mse, 3, 1).value, 4);
    EXPECT_DOUBLE_EQ(lossTerm(Loss::L1, 3, 5).value, 2);
    EXPECT_DOUBLE_EQ(lossTerm(Loss::Smape, 3, 1).value, 2 / 4.01);
    EXPECT_DOUBLE_EQ(lossTerm(Loss::RelativeMse, 3, 2).value, 1 / 4.01);
    // The target rules the denominator: relative-mse is not symmetric, smape is.
    EXPECT_DOUBLE_EQ(lossTerm(Loss::RelativeMse, 2, 3).value, 1 / 9.01);
    EXPECT_DOUBLE_EQ(lossTerm(Loss::Smape, 1, 3).value, 2 / 4.01);
}

TEST(Losses, DerivativesAgreeWithCentralDifferences) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> uniform(-1, 3);
    for (const Loss loss : kAll)
        for (int i = 0; i < 200; ++i) {
            const double x = uniform(random), y = uniform(random), h = 1e-5;
            if (std::abs(x - y) < 1e-3 || std::abs(x) < 1e-3)
                continue; // a kink would lie inside the difference
            const double numeric = (lossTerm(loss, x + h, y).value - lossTerm(loss, x - h, y).value) / (2 * h);
            // Truncation is h^2 f'''/6 < 1e-7 (smape near 0 has the largest f'''), rounding 1e-16/h = 1e-11.
            EXPECT_NEAR(lossTerm(loss, x, y).derivative, numeric, 1e-6 * std::max(1.0, std::abs(numeric)))
                << nameOf(loss, kLosses) << " " << x << " " << y;
        }
}

TEST(Losses, MeanOverUnmaskedPixelsAndChannels) {
    const Pair pair = makePair();
    for (const Loss loss : kAll)
        for (const bool masked : {false, true}) {
            double sum = 0, total = 0;
            for (std::size_t p = 0; p < 35; ++p)
                for (std::size_t c = 0; c < 3; ++c) {
                    const double w = masked ? pair.mask[p] : 1.0;
                    sum += w * lossTerm(loss, pair.image.values[3 * p + c], pair.target.values[3 * p + c]).value;
                    total += w;
                }
            const LossResult result = evaluateLoss(loss, pair.image, pair.target, masked ? pair.mask : std::vector<float>());
            EXPECT_NEAR(result.value, sum / total, 1e-13);
            for (std::size_t p = 0; p < 35; ++p)
                for (std::size_t c = 0; c < 3; ++c) {
                    const double w = masked ? pair.mask[p] : 1.0;
                    const std::size_t i = 3 * p + c;
                    const double expected = w * lossTerm(loss, pair.image.values[i], pair.target.values[i]).derivative / total;
                    EXPECT_NEAR(result.adjoint.values[i], expected, 1e-7 * std::abs(expected)); // one float rounding
                }
        }
}

TEST(Losses, AdjointOfTheWholeImageAgreesWithCentralDifferences) {
    for (const Loss loss : kAll) {
        Pair pair = makePair();
        const Image adjoint = evaluateLoss(loss, pair.image, pair.target, pair.mask).adjoint;
        for (std::size_t i = 0; i < pair.image.values.size(); ++i) {
            const float x = pair.image.values[i];
            if (std::abs(x - pair.target.values[i]) < 0.01f || x < 0.01f)
                continue;
            pair.image.values[i] = x + 1e-4f;
            const double up = pair.image.values[i], above = evaluateLoss(loss, pair.image, pair.target, pair.mask).value;
            pair.image.values[i] = x - 1e-4f;
            const double down = pair.image.values[i], below = evaluateLoss(loss, pair.image, pair.target, pair.mask).value;
            pair.image.values[i] = x;
            // 1e-6 of the largest possible derivative of one value; the division by up - down takes out the rounding of x +- h.
            EXPECT_NEAR(adjoint.values[i], (above - below) / (up - down), 1e-6) << nameOf(loss, kLosses);
        }
    }
}

TEST(Losses, MaskedPixelsDoNotMatterWhateverTheyHold) {
    Pair pair = makePair();
    const LossResult before = evaluateLoss(Loss::Smape, pair.image, pair.target, pair.mask);
    pair.target.values[0] = std::nanf("");
    pair.image.values[1] = INFINITY;
    const LossResult after = evaluateLoss(Loss::Smape, pair.image, pair.target, pair.mask);
    EXPECT_EQ(before.value, after.value);
    EXPECT_EQ(before.adjoint.values, after.adjoint.values);
    EXPECT_EQ(after.nonFinite, 0u);
}

TEST(Losses, ClippedValuesAreLowerBounds) {
    const Pair pair = makePair();
    std::vector<std::uint8_t> clipped(pair.target.values.size());
    for (std::size_t i = 0; i < clipped.size(); ++i)
        clipped[i] = i % 3 != 1; // the other channel of a pixel is what it says
    for (const Loss loss : kAll) {
        const LossResult plain = evaluateLoss(loss, pair.image, pair.target, pair.mask), bounded = evaluateLoss(loss, pair.image, pair.target, pair.mask, clipped);
        double beyond = 0;
        std::size_t without = 0;
        for (std::size_t i = 0; i < clipped.size(); ++i) {
            const bool brighter = clipped[i] && pair.image.values[i] >= pair.target.values[i];
            beyond += brighter ? pair.mask[i / 3] * lossTerm(loss, pair.image.values[i], pair.target.values[i]).value : 0;
            without += brighter;
            EXPECT_EQ(bounded.adjoint.values[i], brighter ? 0 : plain.adjoint.values[i]) << i;
        }
        EXPECT_GT(without, 20u);
        EXPECT_NEAR(bounded.value, plain.value - beyond / bounded.values, 1e-12);
        EXPECT_EQ(bounded.values, plain.values);
    }
}

// Noise that cancels between the halves does not make an image too dark.
TEST(Losses, ClippedValuesAreComparedWithTheMeanOfTheHalves) {
    const Image target(1, 1, 3, 1.f);
    const std::vector<std::uint8_t> clipped(3, 1);
    EXPECT_EQ(evaluateLoss(Loss::Mse, {Image(1, 1, 3, 0.5f), Image(1, 1, 3, 1.75f)}, target, {}, clipped).value, 0);
    EXPECT_DOUBLE_EQ(evaluateLoss(Loss::Mse, {Image(1, 1, 3, 0.5f), Image(1, 1, 3, 0.75f)}, target, {}, clipped).value, 0.125);
}

TEST(Losses, NonFinitePixelsAreCountedAndLeftOut) {
    Pair pair = makePair();
    pair.image.values[5] = std::nanf("");
    pair.image.values[9] = -INFINITY;
    const LossResult result = evaluateLoss(Loss::Mse, pair.image, pair.target);
    EXPECT_EQ(result.nonFinite, 2u);
    EXPECT_TRUE(std::isfinite(result.value));
    for (const std::size_t i : {3u, 4u, 5u, 9u, 10u, 11u})
        EXPECT_EQ(result.adjoint.values[i], 0);
}

TEST(Losses, RefusesWhatCannotBeCompared) {
    const Image image(4, 4, 3), other(4, 5, 3);
    EXPECT_THROW(evaluateLoss(Loss::Mse, image, other), Error);
    EXPECT_THROW(evaluateLoss(Loss::Mse, image, image, std::vector<float>(15, 1.f)), Error);
    EXPECT_THROW(evaluateLoss(Loss::Mse, image, image, std::vector<float>(16, 0.f)), Error);
}

// Of images with noise: squared losses of two halves are those of the image without it. 400 draws; six standard errors are more than any
// chance. The error told is the spread found, within its own tenth.
TEST(Loss, OfTwoHalvesHasNoBiasByNoise) {
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    std::uniform_real_distribution<float> uniform(0.1f, 1);
    Image clean(16, 16, 3), target(16, 16, 3);
    for (std::size_t i = 0; i < clean.values.size(); ++i) {
        clean.values[i] = uniform(random);
        target.values[i] = clean.values[i] + 0.05f * normal(random);
    }
    for (const Loss loss : {Loss::Mse, Loss::RelativeMse}) {
        const double truth = evaluateLoss(loss, clean, target).value;
        constexpr int kDraws = 400;
        double sum = 0, squares = 0, told = 0;
        for (int draw = 0; draw < kDraws; ++draw) {
            std::array<Image, 2> halves{clean, clean};
            for (Image& half : halves)
                for (float& v : half.values)
                    v += 0.2f * normal(random);
            const LossResult result = evaluateLoss(loss, halves, target);
            sum += result.value;
            squares += result.value * result.value;
            told += result.error / kDraws;
        }
        const double mean = sum / kDraws, spread = std::sqrt(squares / kDraws - mean * mean);
        EXPECT_LT(std::abs(mean - truth), 6 * spread / std::sqrt(double(kDraws))) << nameOf(loss, kLosses);
        EXPECT_NEAR(told, spread, 0.1 * spread) << nameOf(loss, kLosses);
    }
}

// One pixel has nearly all of the noise, as of a small lamp: where its halves are far off to both sides, the loss is far below 0, and so is not known to that.
// 1000 draws, fixed seed.
TEST(Loss, IsNeverSurelyNegative) {
    std::mt19937 random(12);
    std::normal_distribution<float> normal;
    const Image target(8, 8, 3);
    int far = 0, negative = 0;
    for (int draw = 0; draw < 1000; ++draw) {
        std::array<Image, 2> halves{target, target};
        for (Image& half : halves)
            for (std::size_t i = 0; i < half.values.size(); ++i)
                half.values[i] = (i == 0 ? 100.f : 0.01f) * normal(random);
        const LossResult result = evaluateLoss(Loss::Mse, halves, target);
        far += result.value < -2 * result.error;
        negative += result.value < 0;
    }
    EXPECT_EQ(far, 0);
    EXPECT_GT(negative, 400);
}

TEST(OrderedSum, AddsFixedChunksInOrder) {
    // Values whose sum depends on the order in the last bits.
    std::vector<double> values(10007);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> exponent(-20, 20);
    for (double& v : values)
        v = std::exp(exponent(random));
    double expected = 0;
    for (std::size_t begin = 0; begin < values.size(); begin += 100) {
        double part = 0;
        for (std::size_t i = begin; i < std::min(begin + 100, values.size()); ++i)
            part += values[i];
        expected += part;
    }
    for (int repeat = 0; repeat < 20; ++repeat)
        ASSERT_EQ(orderedSum<double>(values.size(), 100,
                                     [&](std::size_t begin, std::size_t end) {
                                         double part = 0;
                                         for (std::size_t i = begin; i < end; ++i)
                                             part += values[i];
                                         return part;
                                     }),
                  expected);
}

} // namespace
} // namespace cmpg
