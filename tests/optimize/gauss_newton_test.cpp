// Gauss-Newton steps against matrices written out, against Adam, and under noise.
#include "linear_model.h"
#include "base/error.h"
#include "optimize/gauss_newton.h"
#include "optimize/optimize.h"

#include <bit>
#include <gtest/gtest.h>
#include <iostream>
#include <numeric>
#include <set>
#include <tuple>

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

double totalVariation(Parameter texture, const std::vector<float>& values, double weight, double epsilon) {
    texture.values = values;
    std::vector<double> ignored(texture.entries());
    return addTotalVariation(texture, weight, ignored, epsilon);
}

// The bound has the gradient of the total variation where it touches it, and lies above it everywhere else.
TEST(TotalVariationBound, TouchesFromAbove) {
    for (const auto& [width, height] : {std::pair{7u, 5u}, {1u, 6u}, {6u, 1u}, {2u, 2u}})
        for (const auto& [u, v] : {std::pair{Wrap::Repeat, Wrap::Repeat}, {Wrap::Clamp, Wrap::Repeat}, {Wrap::Clamp, Wrap::Mirror}}) {
            Parameter texture = randomTexture(width, height);
            texture.wrapU = u;
            texture.wrapV = v;
            constexpr double kWeight = 0.7, kEpsilon = 0.05;
            TotalVariationBound bound(texture);
            bound.add(texture, kWeight, kEpsilon);
            const std::size_t count = texture.entries();
            std::vector<double> gradient(count);
            const double here = addTotalVariation(texture, kWeight, gradient, kEpsilon);

            std::vector<float> none(count, 0.f), image(count), diagonal(count);
            bound.multiply(none, texture.values, image); // L x is the gradient: both are sums of d / sqrt(d^2 + eps^2)
            bound.diagonal(none, diagonal);
            for (std::size_t i = 0; i < count; ++i) {
                EXPECT_NEAR(image[i], gradient[i], 1e-6) << width << " x " << height << ", entry " << i;
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
                EXPECT_LE(totalVariation(texture, moved, kWeight, kEpsilon), here + linear + quadratic + 1e-6);
            }
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
        known.add(texture, 10.0 * double(count), 0.01);
        addTotalVariation(texture, 10.0 * double(count), gradient, 0.01);
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
        known.add(texture, 0.1, 0.01);
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

OptimizeConfig newtonConfig(OptimizerKind kind) {
    OptimizeConfig config;
    config.optimizer.kind = kind;
    config.optimizer.rates.fill(0.04f);
    config.sppDifference = 8;
    config.targets = makeTargets(2, 16, 16);
    return config;
}

double errorAfter(OptimizerKind kind, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.3);
    Optimization run(model, scene, newtonConfig(kind), {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

TEST(GaussNewton, ComesNearerThanAdamInAsManySteps) {
    EXPECT_LT(errorAfter(OptimizerKind::Auto, 20), 0.5 * errorAfter(OptimizerKind::Adam, 20));
    EXPECT_LT(errorAfter(OptimizerKind::Auto, 60), 0.02);
}

// Of targets that are clipped at the mean of their values, and say so or not.
double errorOfClipped(bool told, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.05);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    for (Target& target : config.targets) {
        std::vector<float>& values = target.image.values;
        const float limit = std::accumulate(values.begin(), values.end(), 0.f) / float(values.size());
        for (float& value : values) {
            if (told)
                target.clipped.push_back(value >= limit);
            value = std::min(value, limit);
        }
    }
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

TEST(GaussNewton, LooksBeyondWhatIsClipped) {
    EXPECT_LT(errorOfClipped(true, 60), 0.02);
    EXPECT_GT(errorOfClipped(false, 60), 0.1);
}

// Per pixel, of the images that steps bring up to date, in a recovery of one view.
std::vector<double> imageSamples(double noise, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 1, 16, 16, noise);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets = makeTargets(1, 16, 16);
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    std::vector<double> samples;
    for (const LinearModel::Call& call : model.calls)
        if (call.kind == 'p' && call.key.firstSample > 0) // the first image has none before it
            samples.push_back(double(call.samples) / (16 * 16));
    return samples;
}

TEST(GaussNewton, ImagesGetSamplesWhenNoiseIsWhatIsLeft) {
    const std::vector<double> noisy = imageSamples(0.3, 40), clean = imageSamples(0, 40);
    ASSERT_EQ(noisy.size(), 39u);
    ASSERT_EQ(clean.size(), 39u);
    EXPECT_GT(noisy.back(), 7); // of 8
    for (const double samples : clean)
        EXPECT_NEAR(samples, 5, 0.3); // between 2 and 8 while gradients are signal
}

double errorAfter(std::vector<Target> targets, double prior, double noise, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, noise);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets = std::move(targets);
    config.prior = prior;
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

// Images are trusted by their noise: the prior pulls noticeably at values while little is known, and no longer when images have told them.
TEST(GaussNewton, PriorFadesAsImagesGetPrecise) {
    const std::vector<Target> targets = makeTargets(2, 16, 16);
    EXPECT_LT(errorAfter(targets, 8, 0, 100), 1e-3);
    const double early = errorAfter(targets, 8, 0.3, 10), late = errorAfter(targets, 8, 0.3, 160);
    EXPECT_LT(late, 0.3 * early);
}

// The prior's weight follows from how far images are off: by the noise of a target as well, which no samples take away.
TEST(GaussNewton, PriorStaysWhereTargetsAreNoisy) {
    const auto weight = [](double off) {
        Scene scene = makeScene();
        LinearModel model(scene, 2, 16, 16, 0);
        OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
        config.prior = 8;
        std::mt19937 random(8);
        std::normal_distribution<float> normal(0, 1);
        for (Target& target : config.targets)
            for (float& value : target.image.values)
                value += float(off) * normal(random);
        Optimization run(model, scene, config, {0, 1});
        while (run.state().step < 60)
            run.step();
        std::vector<double> ignored(scene.parameters[0].entries());
        const double variation = addTotalVariation(scene.parameters[0], 1, ignored, kPriorEpsilon);
        return run.step().regularizer / variation;
    };
    constexpr double kOff = 0.02, kEntries = 48, kValues = 2 * 16 * 16 * 3;
    EXPECT_NEAR(weight(kOff) / (8 * kEntries * 2 * kOff * kOff / kValues), 1, 0.2);
    EXPECT_LT(weight(0), 0.1 * weight(kOff));
}

// A texture of light, recovered from one noisy view that shows it `brightness` times as bright, from a hundredth of that.
std::vector<float> recoveredLight(float brightness, double prior, double noise, std::uint32_t steps) {
    const auto scene = [&](bool truth) {
        Scene made;
        made.parameters.push_back(makeParameter("lamp.emission", SlotKind::Emission, 4, 4, 3, 0.01f * brightness));
        const std::vector<float> values = makeTruth().parameters[0].values;
        for (std::size_t i = 0; truth && i < values.size(); ++i)
            made.parameters[0].values[i] = values[i] * brightness;
        return made;
    };
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.prior = prior;
    config.targets.resize(1);
    config.targets[0].image = LinearModel(scene(true), 1, 16, 16, 0).render(0, 1, {});
    Scene made = scene(false);
    LinearModel model(made, 1, 16, 16, noise);
    Optimization run(model, made, config, {0});
    while (run.state().step < steps)
        run.step();
    return made.parameters[0].values;
}

TEST(GaussNewton, ReachesLightFromFarTooDark) {
    const std::vector<float> truth = makeTruth().parameters[0].values, found = recoveredLight(1, 0, 0, 40);
    for (std::size_t i = 0; i < truth.size(); ++i)
        EXPECT_NEAR(found[i], truth[i], 0.02);
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

// The prior of light has no unit of its own: twice as bright is recovered as twice the values. And it smoothes while images are noisy.
TEST(GaussNewton, PriorOfLightIsTheSameAtAnyBrightness) {
    const std::vector<float> one = recoveredLight(1, 400, 0.3, 20), bright = recoveredLight(1024, 400, 0.3, 20), without = recoveredLight(1, 0, 0.3, 20);
    for (std::size_t i = 0; i < one.size(); ++i)
        EXPECT_NEAR(bright[i] / 1024, one[i], 1e-4);
    const auto variation = [](const std::vector<float>& values) {
        Parameter texture = makeParameter("lamp.emission", SlotKind::Emission, 4, 4, 3, 0);
        texture.values = values;
        std::vector<double> ignored(texture.entries());
        return addTotalVariation(texture, 1, ignored);
    };
    EXPECT_LT(variation(one), 0.9 * variation(without));
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

// Pixels that answer to the parameters get the samples, every pixel one at least, and all together about as many as asked for.
TEST(GaussNewton, ImagesAreSampledWhereTheyAnswer) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.3);
    Optimization run(model, scene, newtonConfig(OptimizerKind::Auto), {0, 1});
    run.step();
    model.calls.clear();
    run.step();
    ASSERT_EQ(run.state().pixelShares.size(), 2u);
    std::uint64_t paths = 0;
    for (const LinearModel::Call& call : model.calls)
        paths += call.kind == 'p' && call.key.step < 2 ? call.samples : 0; // beside those that measure the curvature
    EXPECT_GT(double(paths), 2.0 * 5 * 256 * 0.9); // half of the samples, and more by the share of noise
    EXPECT_LT(double(paths), 2.0 * 8 * 256 * 1.1);
}

// Error after as many passes of a view as `steps` of all six take, of a texture alone.
double errorOfViews(std::uint32_t viewsPerStep, std::uint32_t steps, double noise, std::size_t imageBytes = std::size_t(1) << 20) {
    Scene scene = makeScene(), truth = makeTruth();
    scene.parameters.pop_back();
    truth.parameters.pop_back();
    LinearModel model(scene, 6, 16, 16, noise), exact(truth, 6, 16, 16, 0);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets.resize(6);
    for (std::size_t view = 0; view < 6; ++view)
        config.targets[view].image = exact.render(view, 1, {});
    config.viewsPerStep = viewsPerStep;
    config.imageBytes = imageBytes;
    Optimization run(model, scene, config, {0});
    const ViewOrder order(config.seed, 6, viewsPerStep);
    while (order.seenBefore(run.state().step) < 6 * steps)
        run.step();
    double squares = 0;
    for (std::size_t i = 0; i < 48; ++i)
        squares += std::pow(double(scene.parameters[0].values[i]) - truth.parameters[0].values[i], 2) / 48;
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (const LinearModel::Call& call : model.calls) {
        EXPECT_TRUE(keys.emplace(call.key.step, call.key.pass, call.key.firstSample).second) << "random numbers used twice";
    }
    std::cout << viewsPerStep << " views a step, error " << std::sqrt(squares) << '\n';
    return std::sqrt(squares);
}

TEST(GaussNewton, ComesNearerWithFewViewsAtFirst) {
    for (const double noise : {0.0, 0.3}) {
        const double all = errorOfViews(6, 3, noise);
        EXPECT_LT(errorOfViews(1, 3, noise), 0.7 * all) << noise;
        EXPECT_LT(errorOfViews(0, 3, noise), 0.7 * all) << noise;
    }
    EXPECT_LT(errorOfViews(0, 20, 0.3), 1.2 * errorOfViews(6, 20, 0.3)); // and no farther at last
}

TEST(GaussNewton, CarriesImagesOfAsManyViewsAsMemoryAllows) {
    for (const std::uint32_t viewsPerStep : {1u, 6u}) {
        Scene scene = makeScene(), truth = makeTruth();
        LinearModel model(scene, 6, 16, 16, 0.3), exact(truth, 6, 16, 16, 0);
        OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
        config.targets.resize(6);
        for (std::size_t view = 0; view < 6; ++view)
            config.targets[view].image = exact.render(view, 1, {});
        config.viewsPerStep = viewsPerStep;
        const std::size_t image = RunningImage::bytes(256), values = 4 * (scene.parameters[0].entries() + scene.parameters[1].entries());
        config.imageBytes = 3 * image + (viewsPerStep == 1 ? 3 : 1) * values; // values of a step that sees all views are of all images
        Optimization run(model, scene, config, {0, 1});
        for (int step = 0; step < 12; ++step)
            run.step();
        std::set<const StepValues*> sets;
        for (std::size_t view = 0; view < 6; ++view) {
            EXPECT_EQ(run.state().images[view].empty(), view >= 3) << view;
            EXPECT_EQ(run.state().imageValues[view] == nullptr, view >= 3) << view;
            sets.insert(run.state().imageValues[view].get());
        }
        EXPECT_EQ(sets.size(), viewsPerStep == 1 ? 4u : 2u); // with none
    }
}

// Images beyond the memory for them begin anew, with random numbers of their own: their noise is larger, and still not what the values fit.
TEST(GaussNewton, RecoversWhereImagesBeginAnew) { EXPECT_LT(errorOfViews(1, 20, 0.3, 0), 4 * errorOfViews(1, 20, 0.3)); }

TEST(GaussNewton, SaysWhatItNeeds) {
    const auto refused = [](auto&& change) {
        OptimizeConfig config = newtonConfig(OptimizerKind::GaussNewton);
        change(config);
        Scene scene = makeScene();
        LinearModel model(scene, 2, 16, 16, 0.3);
        try {
            Optimization run(model, scene, config, {0, 1});
            return false;
        } catch (const Error& error) {
            return error.kind == ErrorKind::Usage && !error.remedy.empty();
        }
    };
    EXPECT_FALSE(refused([](OptimizeConfig&) {}));
    EXPECT_TRUE(refused([](OptimizeConfig& c) { c.loss = Loss::L1; }));
    EXPECT_TRUE(refused([](OptimizeConfig& c) { c.sppDifference = 0; }));
    EXPECT_FALSE(refused([](OptimizeConfig& c) { c.viewsPerStep = 1; }));
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::BaseColor, true), OptimizerKind::GaussNewton);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::BaseColor, false), OptimizerKind::Adam);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::Roughness, true), OptimizerKind::GaussNewton);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::Normal, true), OptimizerKind::Adam);
    EXPECT_EQ(methodOf(OptimizerKind::Sgd, SlotKind::BaseColor, true), OptimizerKind::Sgd);
}

} // namespace
} // namespace cmpg::test
