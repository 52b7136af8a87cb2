// Gauss-Newton steps of one parameter against matrices written out, and under noise. Recoveries: gauss_newton_recovery_test.cpp.
#include "linear_model.h"
#include "optimize/gauss_newton.h"

#include <bit>
#include <gtest/gtest.h>
#include <numeric>

namespace cmpg::test {
namespace {

Parameter randomTexture(std::uint32_t width, std::uint32_t height) {
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, width, height, 3, 0);
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float& value : texture.values)
        value = uniform(random);
    return texture;
}

double totalVariation(Parameter texture, const std::vector<float>& values, double weight, const DifferenceCost& cost, const ExpectedDifferences& expected,
                      const std::vector<float>& strengths) {
    texture.values = values;
    std::vector<double> ignored(texture.entries());
    return addTotalVariation(texture, weight, ignored, cost, expected, strengths);
}

// The bound has the gradient of the total variation where it touches it, and lies above it everywhere else.
void expectTouching(const Parameter& texture, const DifferenceCost& cost, const ExpectedDifferences& expected, const std::vector<float>& strengths) {
    constexpr double kWeight = 0.7;
    TotalVariationBound bound(texture);
    bound.add(texture, kWeight, cost, expected, strengths);
    const std::size_t count = texture.entries();
    std::vector<double> gradient(count);
    const double here = addTotalVariation(texture, kWeight, gradient, cost, expected, strengths);

    std::vector<float> none(count, 0.f), image(count), diagonal(count);
    bound.multiply(none, texture.values, image);
    bound.diagonal(none, diagonal);
    for (std::size_t i = 0; i < count; ++i) {
        if (expected.empty()) {
            EXPECT_NEAR(image[i], gradient[i], 1e-6) << i; // both are sums of differences times f'/r
        }
        std::vector<float> unit(count, 0.f), column(count);
        unit[i] = 1;
        bound.multiply(none, unit, column);
        EXPECT_NEAR(column[i], diagonal[i], 1e-6 * (1 + diagonal[i]));
    }
    std::mt19937 random(5);
    std::normal_distribution<float> normal(0, 0.2f);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<float> moved = texture.values, change(count);
        double linear = 0, quadratic = 0;
        for (std::size_t i = 0; i < count; ++i) {
            change[i] = normal(random);
            moved[i] += change[i];
            linear += gradient[i] * change[i];
        }
        bound.multiply(none, change, image);
        for (std::size_t i = 0; i < count; ++i)
            quadratic += 0.5 * double(image[i]) * change[i];
        EXPECT_LE(totalVariation(texture, moved, kWeight, cost, expected, strengths), here + linear + quadratic + 1e-6);
    }
}

TEST(TotalVariationBound, TouchesFromAbove) {
    for (const auto& [width, height] : {std::pair{7u, 5u}, {1u, 6u}, {6u, 1u}, {2u, 2u}})
        for (const auto& [u, v] : {std::pair{Wrap::Repeat, Wrap::Repeat}, {Wrap::Clamp, Wrap::Repeat}, {Wrap::Clamp, Wrap::Mirror}}) {
            SCOPED_TRACE(testing::Message() << width << " x " << height);
            Parameter texture = randomTexture(width, height);
            texture.wrapU = u;
            texture.wrapV = v;
            const std::vector<float> guess = randomTexture(width, height).values;
            const std::vector<bool> seen(std::size_t(width) * height);
            for (const DifferenceCost& cost : {DifferenceCost{0.05}, DifferenceCost{0.05, 0.1}})
                for (const ExpectedDifferences& expected : {ExpectedDifferences(), expectedDifferences(gridOf(texture), guess, seen)})
                    for (const std::vector<float>& strengths : {std::vector<float>(), std::vector<float>(guess.begin(), guess.begin() + width * height)})
                        expectTouching(texture, cost, expected, strengths);
        }
}

// Where the measured curvature is the true one and nothing is noise, the minimum of a quadratic is a step and its momentum away: of dim scenes and of
// bright ones.
class Quadratic : public testing::TestWithParam<double> {};

TEST_P(Quadratic, MinimumIsFound) {
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f);
    const Parameter truth = randomTexture(4, 4);
    OptimizerConfig config;
    config.kind = OptimizerKind::GaussNewton;
    Moments moments = initialMoments(config, texture);
    std::vector<double> curvature(48), product(48), gradient(48);
    const std::vector<double> noise(48, 0.0);
    for (std::size_t i = 0; i < 48; ++i) {
        curvature[i] = GetParam() * std::pow(10, double(i % 7) - 3);
        product[i] = 0.05 * curvature[i];
    }
    addCurvature(product, {0.05f}, moments);
    const auto farthest = [&] {
        double worst = 0;
        for (std::size_t i = 0; i < 48; ++i)
            worst = std::max(worst, std::abs(double(texture.values[i]) - truth.values[i]) * (i % 7 >= 3 ? 1 : 0)); // flatter ones are held back by what paths may miss
        return worst;
    };
    for (int step = 0; step < 25; ++step) {
        for (std::size_t i = 0; i < 48; ++i)
            gradient[i] = curvature[i] * (double(texture.values[i]) - truth.values[i]);
        EXPECT_EQ(updateByGaussNewton(0.05, {gradient, noise}, TotalVariationBound(texture), moments, texture), 0u);
    }
    EXPECT_LT(farthest(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(GaussNewton, Quadratic, testing::Values(1e-30, 1e-12, 1.0, 1e15));

// The gradient of what is at its minimum is all noise: values stray less than half as far as one full step takes them.
TEST(GaussNewton, FollowsNoNoise) {
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 32, 32, 3, 0.5f);
    OptimizerConfig config;
    config.kind = OptimizerKind::GaussNewton;
    Moments moments = initialMoments(config, texture);
    const std::size_t count = texture.entries();
    std::vector<double> gradient(count), half(count);
    addCurvature(std::vector<double>(count, 0.05), {0.05f}, moments); // curvature 1
    std::mt19937 random(6);
    constexpr double kNoise = 0.1;
    std::normal_distribution<double> normal(0, kNoise * std::sqrt(2));
    for (int step = 0; step < 40; ++step) {
        for (std::size_t i = 0; i < count; ++i) {
            const double a = normal(random), b = normal(random), pull = double(texture.values[i]) - 0.5;
            gradient[i] = pull + 0.5 * (a + b);
            half[i] = 0.5 * (a - b);
        }
        updateByGaussNewton(0.2, {gradient, half}, TotalVariationBound(texture), moments, texture);
    }
    double squares = 0;
    for (const float value : texture.values)
        squares += (double(value) - 0.5) * (double(value) - 0.5) / double(count);
    EXPECT_LT(std::sqrt(squares), 0.5 * kNoise); // full steps and their momentum leave 1.15 kNoise
    EXPECT_LT(moments.noise[0].signal, moments.noise[0].noise);
}

// On a coarser grid: what is smooth is found as on the texture's own, and what a texel differs by within one of that grid stays.
TEST(GaussNewton, CoarserGridsLeaveWhatIsWithinTheirTexels) {
    const auto wave = [](std::size_t entry) { return 0.5f + 0.2f * std::sin(float(entry / 3 % 32) * 0.19635f); }; // once around
    const auto detail = [](std::size_t entry) { return entry / 3 % 2 == 0 ? 0.03f : -0.03f; };
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 32, 32, 3, 0.5f);
    const std::size_t count = texture.entries();
    for (std::size_t i = 0; i < count; ++i)
        texture.values[i] += detail(i);
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
    addCurvature(std::vector<double>(count, 0.05), {0.05f}, moments); // curvature 1
    const CoarseTexture coarse(gridOf(texture), 4);
    for (int step = 0; step < 30; ++step) {
        std::vector<double> gradient(count);
        for (std::size_t i = 0; i < count; ++i)
            gradient[i] = double(texture.values[i]) - wave(i); // also asks for an end of the detail
        updateByGaussNewton(0.05, {gradient, std::vector<double>(count)}, TotalVariationBound(texture), moments, texture, 0, &coarse);
    }
    for (std::size_t i = 0; i < count; ++i)
        EXPECT_NEAR(texture.values[i], wave(i) + detail(i), 0.01) << i;
    EXPECT_EQ(moments.noise.size(), 1u) << "nothing connects texels";
    EXPECT_EQ(moments.noise[0].squares.size(), 8u * 8u * 3u);
}

// Momentum goes on where gradients are signal. Of a lobe's shape it has gone where more than a quarter of them is noise, of colours it has not.
TEST(GaussNewton, ShapesOfLobesHaveNoMomentumInNoise) {
    const auto secondMove = [](SlotKind kind, double noise) {
        Parameter texture = makeParameter("m.slot", kind, 8, 8, kind == SlotKind::BaseColor ? 3 : 1, 0.5f);
        Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
        const std::size_t count = texture.entries();
        addCurvature(std::vector<double>(count, 0.05), {0.05f}, moments); // curvature 1
        const std::vector<double> first(count, 0.01), none(count, 0.0);
        const TotalVariationBound known(texture);
        updateByGaussNewton(0.04, {first, std::vector<double>(count, noise)}, known, moments, texture);
        const float before = texture.values[0];
        updateByGaussNewton(0.04, {none, std::vector<double>(count, noise)}, known, moments, texture); // all that moves is momentum
        return before - texture.values[0];
    };
    EXPECT_GT(secondMove(SlotKind::Roughness, 0), 0.002f);
    EXPECT_GT(secondMove(SlotKind::BaseColor, 0.008), 0.0001f);
    EXPECT_EQ(secondMove(SlotKind::Roughness, 0.008), 0.f);
}

// Where the noise of a texel is ten times what separates it from its value, and that of all texels together a third of it, what they have in
// common arrives within a few steps, and texels hold still meanwhile.
TEST(GaussNewton, FollowsWhatTexelsHaveInCommon) {
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 32, 32, 3, 0.8f);
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
    const std::size_t count = texture.entries();
    std::vector<double> gradient(count), half(count);
    addCurvature(std::vector<double>(count, 0.05), {0.05f}, moments); // curvature 1
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, 4 * std::sqrt(2));
    for (int step = 0; step < 12; ++step) {
        for (std::size_t i = 0; i < count; ++i) {
            const double a = normal(random), b = normal(random);
            gradient[i] = double(texture.values[i]) - 0.4 + 0.5 * (a + b);
            half[i] = 0.5 * (a - b);
        }
        TotalVariationBound known(texture);
        known.add(texture, 10.0 * double(count), kPriorCost);
        addTotalVariation(texture, 10.0 * double(count), gradient, kPriorCost);
        updateByGaussNewton(0.04, {gradient, half}, known, moments, texture);
    }
    double sum = 0, squares = 0;
    for (const float value : texture.values) {
        sum += value / double(count);
        squares += (double(value) - 0.4) * (double(value) - 0.4) / double(count);
    }
    EXPECT_NEAR(sum, 0.4, 0.1); // a step on the texture alone is bounded by its noise: 0.04 / 4 of what is left
    EXPECT_LT(std::sqrt(squares), 0.15);
    ASSERT_EQ(moments.noise.size(), 4u); // 32, 8, 2 and 1 texels wide
    EXPECT_LT(signalShare(moments.noise[0]), 0.1);
}

TEST(GaussNewton, StandsAnyGradient) {
    for (const double bad : {std::nan(""), double(INFINITY), 1e300, -1e25}) {
        Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f);
        OptimizerConfig config;
        config.kind = OptimizerKind::GaussNewton;
        Moments moments = initialMoments(config, texture);
        std::vector<double> product(48, 0.05), gradient(48, 0.1);
        product[1] = bad;
        gradient[0] = gradient[1] = bad;
        addCurvature(product, {0.05f}, moments);
        TotalVariationBound known(texture);
        known.add(texture, 0.1, {0.01});
        EXPECT_EQ(updateByGaussNewton(0.02, {gradient, gradient}, known, moments, texture), 2u) << bad;
        for (const float value : texture.values)
            EXPECT_TRUE(value >= 0 && value <= 1) << bad;
        EXPECT_TRUE(std::isfinite(moments.noise[0].signal) && std::isfinite(moments.noise[0].noise)) << bad;
    }
    // Nothing is known of the curvature: no path met the texture. It stays.
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f);
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
    const std::vector<double> none(48, 0.0);
    updateByGaussNewton(0.02, {none, none}, TotalVariationBound(texture), moments, texture);
    EXPECT_EQ(texture.values, std::vector<float>(48, 0.5f));
}

// Two views in turns: each sees entries of its own, and both see the others. Every entry arrives as soon as with both views in every step, and goes no
// farther than that although steps of one view have no part of the other's.
TEST(GaussNewton, ViewsInTurnsOvershootNowhere) {
    Parameter texture = makeParameter("m.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f);
    const Parameter truth = randomTexture(4, 4);
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
    const auto curvature = [](std::size_t view, std::size_t i) { return i % 3 == 2 ? 1.0 + double(view) : i % 3 == view ? 2.0 : 0.0; };
    const std::vector<double> none(48);
    for (int step = 0; step < 12; ++step) {
        const std::size_t view = step % 2;
        std::vector<double> part(48), largest(48), gradient(48);
        for (std::size_t i = 0; i < 48; ++i) {
            largest[i] = 0.05 * curvature(view, i);
            part[i] = largest[i] / 2;
            gradient[i] = curvature(view, i) * (double(texture.values[i]) - truth.values[i]);
        }
        if (step < 2)
            addCurvature(part, largest, {0.05f}, 0, moments);
        const std::vector<float> before = texture.values;
        updateByGaussNewton(0.04, {gradient, none, 0.5}, TotalVariationBound(texture), moments, texture);
        for (std::size_t i = 0; i < 48; ++i)
            EXPECT_LE(std::abs(texture.values[i] - truth.values[i]), std::abs(before[i] - truth.values[i]) + 1e-6f) << "step " << step << ", entry " << i;
    }
    for (std::size_t i = 0; i < 48; ++i)
        EXPECT_NEAR(texture.values[i], truth.values[i], 0.01f) << i;
}

// The brightest texel of a sky of light, a thousand times as bright as the others, found from where all are alike. Pixels see half of the sky each, as matt surfaces
// do. `own`: steps and curvature are measured by the values of texels, instead of by one unit for all.
float recoveredSun(float truth, bool own) {
    constexpr std::size_t kTexels = 64, kSun = 21;
    Parameter sky = makeParameter("environment.radiance", SlotKind::Radiance, kTexels, 1, 1, 0.5f);
    const auto curvature = [](std::span<const double> x) {
        std::vector<double> image(kTexels), y(kTexels);
        for (std::size_t p = 0; p < kTexels; ++p)
            for (std::size_t k = 0; k < kTexels / 2; ++k)
                image[p] += x[(p + k) % kTexels] / kTexels;
        for (std::size_t p = 0; p < kTexels; ++p)
            for (std::size_t k = 0; k < kTexels / 2; ++k)
                y[(p + k) % kTexels] += image[p] / kTexels;
        return y;
    };
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, sky);
    const std::vector<double> noise(kTexels, 0.0);
    for (std::uint32_t step = 0; step < 160; ++step) {
        if (step == 0 || (step >= 8 && std::has_single_bit(step))) {
            const CurvatureDirection direction{0.025f, own ? sky.values : std::span<const float>(), 0.05f};
            std::vector<double> moved(kTexels);
            for (std::size_t i = 0; i < kTexels; ++i)
                moved[i] = direction[i];
            addCurvature(curvature(moved), direction, moments);
        }
        std::vector<double> error(sky.values.begin(), sky.values.end());
        for (std::size_t i = 0; i < kTexels; ++i)
            error[i] -= i == kSun ? truth : truth / 1000;
        const double unit = std::max(0.5, std::accumulate(sky.values.begin(), sky.values.end(), 0.0) / kTexels);
        updateByGaussNewton(0.02 * unit, {curvature(error), noise}, TotalVariationBound(sky), moments, sky, own ? unit : 0);
    }
    EXPECT_EQ(std::max_element(sky.values.begin(), sky.values.end()) - sky.values.begin(), std::ptrdiff_t(kSun));
    return sky.values[kSun];
}

TEST(GaussNewton, ReachesASun) {
    constexpr float kTruth = 300;
    const float found = recoveredSun(kTruth, true);
    EXPECT_NEAR(found, kTruth, 0.1f * kTruth);
    EXPECT_LT(std::abs(found - kTruth), 0.25f * std::abs(recoveredSun(kTruth, false) - kTruth));
}

// What images hardly tell, such as texels finer than a pixel: a diagonal bounds the curvature from far above.
TEST(GaussNewton, ReachesBlurredTexels) {
    constexpr std::size_t kTexels = 32;
    Parameter texture = makeParameter("m.roughness", SlotKind::Roughness, kTexels, 1, 1, 0.5f);
    Moments moments = initialMoments({.kind = OptimizerKind::GaussNewton}, texture);
    const auto blurred = [&](std::span<const double> x) { // the mean of each texel and its neighbours, with weights 1, 2, 1
        std::vector<double> y(kTexels);
        for (std::size_t i = 0; i < kTexels; ++i)
            y[i] = 0.25 * x[i > 0 ? i - 1 : i] + 0.5 * x[i] + 0.25 * x[i + 1 < kTexels ? i + 1 : i];
        return y;
    };
    const auto curvature = [&](std::span<const double> x) { return blurred(blurred(x)); };
    std::vector<double> product = curvature(std::vector<double>(kTexels, 0.05)), error(kTexels);
    addCurvature(product, {0.05f}, moments);
    const std::vector<double> noise(kTexels, 0.0);
    const auto truth = [](std::size_t i) { return i % 3 == 0 ? 0.7 : 0.4; };
    double squares = 0;
    for (int step = 0; step < 60; ++step) {
        squares = 0;
        for (std::size_t i = 0; i < kTexels; ++i) {
            error[i] = double(texture.values[i]) - truth(i);
            squares += error[i] * error[i] / kTexels;
        }
        updateByGaussNewton(0.04, {curvature(error), noise}, TotalVariationBound(texture), moments, texture);
    }
    EXPECT_LT(std::sqrt(squares), 0.01);
}

} // namespace
} // namespace cmpg::test
