// How far an image is off its target, as the weight of the prior sees it.
#include "optimize/residual.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cmpg {
namespace {

RunningImage both(const Image& image) {
    RunningImage running;
    running.half = {image, image};
    return running;
}

Target grey(int width, int height, float value) {
    Target target;
    target.image = Image(width, height, 3, value);
    return target;
}

TEST(Residual, ToleratesATenthOfTheMean) {
    Target target = grey(8, 8, 0.5f);
    EXPECT_NEAR(toleratedLoss(Loss::Mse, target), 0.05 * 0.05, 1e-8);
    target.image.at(0, 0)[0] = NAN; // masked, like all that is not finite
    target.mask.assign(64, 1);
    target.mask[0] = 0;
    EXPECT_NEAR(toleratedLoss(Loss::Mse, target), 0.05 * 0.05, 1e-8);
}

TEST(Residual, WeighsPixelsByTheSquareOfTheirAnswer) {
    const Target target = grey(2, 1, 0.5f);
    Image image(2, 1, 3, 0.5f);
    for (int c = 0; c < 3; ++c) {
        image.at(0, 0)[c] += 0.1f;
        image.at(1, 0)[c] += 0.2f;
    }
    EXPECT_NEAR(residual(Loss::Mse, both(image), target, {})->whole, (0.01 + 0.04) / 2, 1e-7);
    EXPECT_NEAR(residual(Loss::Mse, both(image), target, std::vector<float>{2, 1})->whole, (4 * 0.01 + 0.04) / 5, 1e-7);
    EXPECT_FALSE(residual(Loss::Mse, both(image), target, std::vector<float>{0, 0}));
}

// One pixel met a lamp by chance.
TEST(Residual, ABrightPixelDoesNotDecideWhatIsExpected) {
    const Target target = grey(64, 64, 0.2f);
    const double tolerated = toleratedLoss(Loss::Mse, target);
    Image image(64, 64, 3, 0.21f);
    const double clean = expectedLoss(Loss::Mse, both(image), target, {}, tolerated).beside(1);
    EXPECT_NEAR(clean, 2 * 1e-4, 1e-7);
    image.at(7, 5)[1] = 10;
    EXPECT_GT(2 * residual(Loss::Mse, both(image), target, {})->whole, 10 * tolerated);
    const double expected = expectedLoss(Loss::Mse, both(image), target, {}, tolerated).beside(1);
    EXPECT_NEAR(expected, clean + 2 * 1000 * tolerated / (64 * 64), 1e-5);
    EXPECT_LT(expected, tolerated);
}

// Neither noise nor an error beyond it makes an image trusted less than what is tolerated.
TEST(Residual, ANoisyImageIsTrustedLess) {
    const Target target = grey(64, 64, 0.2f);
    const double tolerated = toleratedLoss(Loss::Mse, target); // 0.02 squared
    const auto expected = [&](float noise, float error) {
        RunningImage running;
        running.half = {Image(64, 64, 3, 0.2f + error + noise), Image(64, 64, 3, 0.2f + error - noise)};
        return expectedLoss(Loss::Mse, running, target, {}, tolerated).beside(1);
    };
    EXPECT_NEAR(expected(0.01f, 0), 2 * 0.01 * 0.01, 1e-7);
    EXPECT_NEAR(expected(0.001f, 0.1f), tolerated, 1e-7);
    EXPECT_NEAR(expected(0.1f, 0), tolerated, 1e-7);
    EXPECT_NEAR(expected(0.1f, 0.1f), tolerated, 1e-7);
}

// The prior of texels twice as fine weighs half.
TEST(Residual, FinerTexelsAreHeldLess) {
    const ExpectedLoss expected{.noise = 0, .beyond = 0.8, .tolerated = 1};
    for (const double coarse : {0.0, 0.2, kTexelsOfPrior})
        EXPECT_EQ(expected.beside(coarse), 0.8);
    EXPECT_DOUBLE_EQ(expected.beside(2 * kTexelsOfPrior), 0.4);
}

// Noise beside texels of 1, 2 and 8 pixels an edge, and of 1.25 and 10 to a pixel.
TEST(Residual, NoiseCountsMoreBesideTexelsSmallerThanAPixel) {
    const ExpectedLoss expected{.noise = 0.1, .beyond = 0.01, .tolerated = 10};
    EXPECT_DOUBLE_EQ(expected.beside(0), 0.11); // not known
    EXPECT_DOUBLE_EQ(expected.beside(1), 0.11);
    EXPECT_DOUBLE_EQ(expected.beside(0.5), 0.06);
    EXPECT_DOUBLE_EQ(expected.beside(0.125), 0.035);
    EXPECT_DOUBLE_EQ(expected.beside(1.25), 0.01 + 0.1 * 1.25 * 1.25 * 1.25);
    EXPECT_DOUBLE_EQ(expected.beside(kTexelsOfPrior), 0.41);
    EXPECT_DOUBLE_EQ(ExpectedLoss({.noise = 5, .tolerated = 10}).beside(2), 10);
}

// The scale of a Laplace distribution is its mean distance, that of a normal one the root of its mean square.
TEST(Residual, ALinearLossExpectsTheMeanDistance) {
    const Target target = grey(64, 64, 0.2f);
    const Image image(64, 64, 3, 0.21f);
    for (const auto& [loss, expected] : {std::pair{Loss::L1, 0.01}, {Loss::Smape, 0.01 / (0.41 + kLossEpsilon)}}) {
        const double tolerated = toleratedLoss(loss, target);
        EXPECT_NEAR(expectedLoss(loss, both(image), target, {}, tolerated).beside(1), expected, 1e-4 * expected);
        EXPECT_LT(expected, tolerated);
        Image bright = image;
        bright.at(7, 5)[1] = 100;
        EXPECT_LT(expectedLoss(loss, both(bright), target, {}, tolerated).beside(1), 1.02 * expected) << "one pixel met a lamp by chance";
    }
}

} // namespace
} // namespace cmpg
