// The check of gradients: passes right ones, catches wrong ones, and says what it could have seen.
#include "optimize/gradient_check.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

// An image that depends on two values like a path tracer's on albedo and roughness: a polynomial and a power, with noise.
struct Model {
    Parameter parameter;
    double noise = 0.05;
    double wrong = 0; // relative error of the derivative; only where x < wrongBelow
    int wrongBelow = 1 << 20;

    static double value(double a, double b, int x) { return 0.3 + a * a * a * (1 + 0.01 * x) + 0.2 * std::sqrt(b + 0.05); }
    static double derivative(double a, double b, double da, double db, int x) {
        return 3 * a * a * da * (1 + 0.01 * x) + 0.1 * db / std::sqrt(b + 0.05);
    }
    template <class F> Image noisy(std::uint32_t seed, F&& f) const {
        Image image(40, 24, 3);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal(1, noise);
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                for (int c = 0; c < 3; ++c)
                    image.at(x, y)[c] = float(f(x) * (noise > 0 ? normal(random) : 1));
        return image;
    }
    CheckSubject subject(float a, float b, std::vector<float> direction) const {
        CheckSubject s;
        s.parameter = &parameter;
        s.values = {a, b};
        s.direction = direction;
        s.forward = [=, this](std::uint32_t r) {
            return noisy(1000 + r,
                         [&](int x) { return derivative(a, b, direction[0], direction[1], x) * (x < wrongBelow ? 1 + wrong : 1); });
        };
        s.difference = [=, this](std::uint32_t r, std::span<const float> v) {
            return ImageDifference{noisy(2000 + r, [&](int x) { return value(a, b, x); }),
                                   noisy(2000 + r, [&](int x) { return value(a, b, x) - value(v[0], v[1], x); })};
        };
        return s;
    }
};

Model model() {
    Model m;
    m.parameter.name = "wall.roughness";
    m.parameter.kind = SlotKind::Roughness;
    m.parameter.width = 2;
    m.parameter.channels = 1;
    return m;
}

TEST(GradientCheck, AgreesWithRightGradients) {
    const Model m = model();
    // Also at the ends of the range, where differences must be one-sided, and with entries that move in opposite directions.
    for (const auto& [a, b] : {std::pair{0.5f, 0.5f}, {0.f, 1.f}, {1.f, 0.f}, {0.002f, 0.4f}})
        for (const std::vector<float>& direction : {std::vector<float>{1, 1}, {1, -1}, {0, 0.01f}}) {
            const CheckResult result = checkGradient(m.subject(a, b, direction));
            EXPECT_TRUE(result.agrees()) << a << " " << b << " " << result.comparisons[0].z();
        }
}

TEST(GradientCheck, NeverLeavesTheRange) {
    const Model m = model();
    for (const float value : {0.f, 0.004f, 0.5f, 0.995f, 1.f}) {
        CheckSubject s = m.subject(value, 1 - value, {1, -2});
        const auto inner = s.difference;
        s.difference = [&](std::uint32_t r, std::span<const float> v) {
            for (const float x : v)
                EXPECT_TRUE(x >= 0 && x <= 1) << x;
            return inner(r, v);
        };
        checkGradient(s);
    }
}

TEST(GradientCheck, CatchesWrongGradients) {
    Model m = model();
    m.wrong = 0.02;
    const CheckResult everywhere = checkGradient(m.subject(0.5f, 0.5f, {1, 1}));
    EXPECT_FALSE(everywhere.agrees()) << everywhere.comparisons[0].z();
    EXPECT_NEAR(everywhere.comparisons[0].relativeError(), 0.02, 0.01);
    m.wrong = 0.1;
    m.wrongBelow = 5; // one column of blocks: 1.25 % of the mean
    EXPECT_FALSE(checkGradient(m.subject(0.5f, 0.5f, {1, 1})).agrees());
    m = model();
    m.noise = 0; // no noise to hide in: only the bound of truncation and rounding is left
    m.wrong = 0.01;
    EXPECT_FALSE(checkGradient(m.subject(0.5f, 0.5f, {1, 1})).agrees());
}

TEST(GradientCheck, StatesItsPower) {
    Model m = model();
    m.noise = 20; // so noisy that a gradient of half the size passes ...
    m.wrong = -0.5;
    const CheckResult result = checkGradient(m.subject(0.5f, 0.5f, {1, 1}));
    EXPECT_TRUE(result.agrees());
    EXPECT_GT(result.comparisons[0].power(), 0.25); // ... which it admits
    m.noise = 0.01;
    m.wrong = 0;
    EXPECT_LT(checkGradient(m.subject(0.5f, 0.5f, {1, 1})).comparisons[0].power(), 0.01);
}

TEST(GradientCheck, NotANumberIsADisagreement) {
    const Model m = model();
    CheckSubject s = m.subject(0.5f, 0.5f, {1, 1});
    s.forward = [](std::uint32_t) { return Image(40, 24, 3, std::nanf("")); };
    EXPECT_FALSE(checkGradient(s).agrees());
}

// With right gradients the check must almost never complain: 6e-5 per check, so not once in 40 (probability of a failure 0.25 %).
TEST(GradientCheck, RarelyRaisesFalseAlarms) {
    Model m = model();
    m.noise = 1;
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        CheckSubject s = m.subject(0.5f, 0.5f, {1, 1});
        const auto forward = s.forward;
        const auto difference = s.difference;
        s.forward = [&](std::uint32_t r) { return forward(r + 10000 * seed); };
        s.difference = [&](std::uint32_t r, std::span<const float> v) { return difference(r + 10000 * seed, v); };
        const CheckResult result = checkGradient(s);
        EXPECT_TRUE(result.agrees()) << seed << " " << result.comparisons[0].z();
    }
}

} // namespace
} // namespace cmpg
