// Adam and SGD against sequences computed by hand, projection, schedules.
#include "linear_model.h"
#include "optimize/optimizer.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

using test::makeParameter;

OptimizerConfig withRate(OptimizerKind kind, float rate) {
    OptimizerConfig config;
    config.kind = kind;
    config.rates.fill(rate);
    return config;
}

TEST(Optimizer, AdamFollowsTheSequenceByHand) {
    OptimizerConfig config = withRate(OptimizerKind::Adam, 0.1f);
    config.epsilon = 0;
    Parameter parameter = makeParameter("m.roughness", SlotKind::Roughness, 1, 1, 1, 0.5f);
    Moments moments = initialMoments(config, parameter);
    // beta 0.9, 0.999. Step 1: m/(1-b1) = 1, v/(1-b2) = 1. Step 2: m = 0.29 / 0.19, v = 0.004999 / 0.001999. Step 3: m = 0.161 / 0.271,
    // v = 0.005994001 / 0.002997001.
    const double gradients[] = {1, 2, -1};
    const double expected[] = {0.4, 0.30348179741782305, 0.2614728670607955};
    for (std::uint32_t step = 0; step < 3; ++step) {
        EXPECT_EQ(updateParameter(config, step, 1, std::span(&gradients[step], 1), moments, parameter), 0u);
        EXPECT_NEAR(parameter.values[0], expected[step], 1e-6);
    }
}

TEST(Optimizer, AdamFollowsADoublePrecisionReference) {
    OptimizerConfig config = withRate(OptimizerKind::Adam, 0.003f);
    Parameter parameter = makeParameter("m.baseColor", SlotKind::BaseColor, 64, 64, 3, 0.5f);
    Moments moments = initialMoments(config, parameter);
    const std::size_t n = parameter.entries();
    std::vector<double> p(n, 0.5), m(n), v(n), g(n);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (std::uint32_t step = 0; step < 50; ++step) {
        for (std::size_t i = 0; i < n; ++i) {
            // Scales from 1e-12 to 1: texel gradients of a mean over a large image are tiny.
            g[i] = (normal(random) + 0.2) * std::pow(10.0, -double(i % 13));
            m[i] = 0.9 * m[i] + 0.1 * g[i];
            v[i] = 0.999 * v[i] + 0.001 * g[i] * g[i];
            p[i] -= 0.003 * (m[i] / (1 - std::pow(0.9, step + 1))) / (std::sqrt(v[i] / (1 - std::pow(0.999, step + 1))) + double(config.epsilon));
            p[i] = std::clamp(p[i], 0.0, 1.0);
        }
        updateParameter(config, step, 1, g, moments, parameter);
    }
    for (std::size_t i = 0; i < n; ++i)
        ASSERT_NEAR(parameter.values[i], p[i], 1e-5) << i; // 50 roundings of values near 0.5 and of steps of 0.003
}

TEST(Optimizer, SgdFollowsTheSequenceByHand) {
    OptimizerConfig config = withRate(OptimizerKind::Sgd, 0.1f);
    config.momentum = 0.9f;
    Parameter parameter = makeParameter("m.roughness", SlotKind::Roughness, 1, 1, 1, 0.9f);
    Moments moments = initialMoments(config, parameter);
    const double gradients[] = {1, 1, -2};
    const double expected[] = {0.8, 0.61, 0.639}; // m = 1, 1.9, -0.29
    for (std::uint32_t step = 0; step < 3; ++step) {
        updateParameter(config, step, 1, std::span(&gradients[step], 1), moments, parameter);
        EXPECT_NEAR(parameter.values[0], expected[step], 1e-6);
    }
    EXPECT_TRUE(moments.second.empty());
}

TEST(Optimizer, SgdMeansTheSameAtEveryResolution) {
    // A uniform change of the loss is spread over the texels of a texture.
    const OptimizerConfig config = withRate(OptimizerKind::Sgd, 0.1f);
    for (const std::uint32_t size : {1u, 4u, 32u}) {
        Parameter parameter = makeParameter("m.baseColor", SlotKind::BaseColor, size, size, 3, 0.5f);
        Moments moments = initialMoments(config, parameter);
        updateParameter(config, 0, 1, std::vector<double>(parameter.entries(), 0.6 / (size * size)), moments, parameter);
        for (const float value : parameter.values)
            ASSERT_NEAR(value, 0.44, 1e-6);
    }
}

TEST(Optimizer, ProjectsToTheRange) {
    const OptimizerConfig config = withRate(OptimizerKind::Adam, 5);
    const double up[] = {-1}, down[] = {1};
    struct Case {
        SlotKind kind;
        float lowest, highest;
    };
    for (const Case& c : {Case{SlotKind::Roughness, 0, 1}, Case{SlotKind::Metallic, 0, 1}, Case{SlotKind::Specular, 0, 1},
                          Case{SlotKind::BaseColor, 0, 1}, Case{SlotKind::Emission, 0, 5.5f}, Case{SlotKind::Radiance, 0, 5.5f}}) {
        Parameter parameter = makeParameter("p", c.kind, 1, 1, 1, 0.5f);
        Moments moments = initialMoments(config, parameter);
        moments.unit = 1;
        updateParameter(config, 0, 1, down, moments, parameter);
        EXPECT_EQ(parameter.values[0], c.lowest);
        parameter.values[0] = 0.5f;
        moments = initialMoments(config, parameter);
        moments.unit = 1;
        updateParameter(config, 0, 1, up, moments, parameter);
        EXPECT_NEAR(parameter.values[0], c.highest, 1e-5);
    }
}

// No diagonal bounds the curvature where the channels of a texture mix: Adam steps these, whoever asks for Gauss-Newton. Normals have axes of their own.
TEST(Optimizer, GaussNewtonLeavesMixedColoursToAdam) {
    for (const OptimizerKind asked : {OptimizerKind::Auto, OptimizerKind::GaussNewton}) {
        EXPECT_EQ(methodOf(asked, SlotKind::SheenColor, true), OptimizerKind::Adam);
        EXPECT_EQ(methodOf(asked, SlotKind::Normal, true), OptimizerKind::GaussNewton);
        EXPECT_EQ(methodOf(asked, SlotKind::BaseColor, true), OptimizerKind::GaussNewton);
    }
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::BaseColor, false), OptimizerKind::Adam);
}

// A normal map of scale 2 has texels like these. Without a gradient they are made unit vectors, and no component is clamped alone.
TEST(Optimizer, LongNormalsKeepTheirDirection) {
    Parameter parameter = makeParameter("m.normal", SlotKind::Normal, 2, 1, 3, 0);
    parameter.values = {1.2f, 0, 0.8f, -1.8f, 1.5f, 0.3f};
    const std::vector<float> before = parameter.values;
    for (const OptimizerKind kind : {OptimizerKind::Adam, OptimizerKind::Sgd}) {
        const OptimizerConfig config = withRate(kind, 0.1f);
        Parameter moved = parameter;
        Moments moments = initialMoments(config, moved);
        updateParameter(config, 0, 1, std::vector<double>(6, 0.0), moments, moved);
        for (std::size_t i = 0; i < 6; ++i) {
            const float* n = before.data() + i / 3 * 3;
            EXPECT_NEAR(moved.values[i], before[i] / std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), 1e-6) << i;
        }
    }
}

TEST(Optimizer, NormalsKeepUnitLength) {
    const OptimizerConfig config = withRate(OptimizerKind::Adam, 0.1f);
    Parameter parameter = makeParameter("m.normal", SlotKind::Normal, 8, 8, 3, 0);
    for (std::size_t i = 2; i < parameter.values.size(); i += 3)
        parameter.values[i] = 1;
    Moments moments = initialMoments(config, parameter);
    std::mt19937 random(6);
    std::normal_distribution<double> normal;
    std::vector<double> gradient(parameter.entries());
    for (std::uint32_t step = 0; step < 30; ++step) {
        for (double& g : gradient)
            g = normal(random);
        updateParameter(config, step, 1, gradient, moments, parameter);
    }
    double tilt = 0;
    for (std::size_t t = 0; t < 64; ++t) {
        const float* n = parameter.values.data() + 3 * t;
        ASSERT_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-6);
        tilt += std::abs(n[0]);
    }
    EXPECT_GT(tilt / 64, 0.05); // they did move
}

TEST(Optimizer, RatesOfUnboundedKindsFollowTheirScale) {
    const OptimizerConfig config = withRate(OptimizerKind::Adam, 0.1f);
    Parameter lamp = makeParameter("lamp.emission", SlotKind::Emission, 1, 1, 3, 200);
    Moments moments = initialMoments(config, lamp);
    updateParameter(config, 0, 1, std::vector<double>(3, 1e-4), moments, lamp);
    EXPECT_NEAR(lamp.values[0], 180, 1e-3);
    Parameter dark = makeParameter("dark.emission", SlotKind::Emission, 1, 1, 3, 0);
    EXPECT_EQ(initialMoments(config, dark).unit, 1);
}

TEST(Optimizer, SkipsAndCountsNonFiniteEntries) {
    for (const OptimizerKind kind : {OptimizerKind::Adam, OptimizerKind::Sgd}) {
        const OptimizerConfig config = withRate(kind, 0.1f);
        Parameter parameter = makeParameter("m.baseColor", SlotKind::BaseColor, 2, 1, 3, 0.5f);
        Moments moments = initialMoments(config, parameter);
        EXPECT_EQ(updateParameter(config, 0, 1, std::vector<double>{1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 0}, moments, parameter), 0u);
        const std::vector<float> values = parameter.values;
        const Moments before = moments;
        EXPECT_EQ(updateParameter(config, 1, 1, std::vector<double>{std::nan(""), INFINITY, 1e300, 0.01, -0.01, 0}, moments, parameter), 3u);
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(parameter.values[i], values[i]);
            EXPECT_EQ(moments.first[i], before.first[i]);
            if (kind == OptimizerKind::Adam) {
                EXPECT_EQ(moments.second[i], before.second[i]);
            }
        }
        EXPECT_LT(parameter.values[3], values[3]);
        EXPECT_GT(parameter.values[4], values[4]);
        EXPECT_EQ(parameter.values[5], 0.5f); // no gradient, no movement
    }
}

TEST(Optimizer, SchedulesRunFromOneToTheFinalFactor) {
    for (const Schedule schedule : {Schedule::Cosine, Schedule::Exponential}) {
        EXPECT_NEAR(scheduleFactor(schedule, 0, 101, 0.04f), 1, 1e-7);
        EXPECT_NEAR(scheduleFactor(schedule, 100, 101, 0.04f), 0.04, 1e-7);
        for (std::uint32_t step = 1; step < 101; ++step)
            EXPECT_LT(scheduleFactor(schedule, step, 101, 0.04f), scheduleFactor(schedule, step - 1, 101, 0.04f));
        EXPECT_EQ(scheduleFactor(schedule, 0, 1, 0.04f), 1);
    }
    EXPECT_NEAR(scheduleFactor(Schedule::Cosine, 50, 101, 0.04f), 0.52, 1e-7);     // arithmetic mean half way
    EXPECT_NEAR(scheduleFactor(Schedule::Exponential, 50, 101, 0.04f), 0.2, 1e-7); // geometric mean
    EXPECT_EQ(scheduleFactor(Schedule::Constant, 77, 101, 0.04f), 1);
}

TEST(Optimizer, ConfiguredRatesReplaceTheDefaultOfTheirKindOnly) {
    OptimizerConfig config;
    config.rates[std::size_t(SlotKind::Emission)] = 0.3f;
    EXPECT_EQ(slotRate(config, SlotKind::Emission), 0.3f);
    EXPECT_EQ(slotRate(config, SlotKind::Normal), kAdamRates[std::size_t(SlotKind::Normal)]);
    config.kind = OptimizerKind::Sgd;
    EXPECT_EQ(slotRate(config, SlotKind::Normal), kSgdRates[std::size_t(SlotKind::Normal)]);
}

} // namespace
} // namespace cmpg
