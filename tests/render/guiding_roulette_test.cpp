// Roulette and splitting: what they cost, and the variances that gate them. Expectations: guiding_unbiased_test.cpp. Seeds are fixed.
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

// Rays per path of a pass.
double cost(GuidedBench& s, const PassPlan& plan) {
    s.plan = plan;
    s.gradient(8, {3, 0, 1});
    const PassResult& m = s.result;
    return double(m.rays) / double(m.paths);
}

TEST(Roulette, KillsAndSplitsByTheReference) {
    GuidedBench s("box", {"painting.baseColor"}, 16);
    const double reference = s.train(3, 16);
    ASSERT_GT(reference, 0);
    const double plain = cost(s, {.method = {Sampling::Conditional}});
    const auto at = [&](double factor) { return cost(s, {.method = {Sampling::Conditional, true}, .reference = factor * reference}); };
    // q = 0.1 at all vertices but those that emit: a camera ray, then a tenth of the rest.
    EXPECT_LT(at(1e6), 1 + 0.3 * (plain - 1));
    EXPECT_GT(at(1e-6), 4 * plain); // q = 4 at most vertices
    EXPECT_LT(at(10), at(1));
    EXPECT_LT(at(1), at(0.1));
    // Records need no part in it: paths end and split all the same. Only the light that the guide alone learns from is left out. The kernels are
    // others, which compilers may round differently.
    const auto gradient = [&](bool record) {
        s.plan = {.method = {.roulette = true}, .record = record, .reference = reference};
        return s.gradient(8, {3, 0, 1})[0];
    };
    const std::vector<double> own = gradient(false), recorded = gradient(true);
    for (std::size_t i = 0; i < own.size(); ++i)
        EXPECT_NEAR(own[i], recorded[i], 1e-6 * std::abs(recorded[i])) << i;
    // Inert where there is nothing to compare with, in images and in forward mode.
    EXPECT_EQ(cost(s, {.method = {Sampling::Conditional, true}}), plain);
    s.renderer->setGuide(misleading(s.renderer->guide(), Misleading::Nothing));
    // A guide that knows nothing ends no path and splits none, but still replaces the roulette of passes without one.
    EXPECT_EQ(at(1), at(10));
    EXPECT_GT(at(1), cost(s, {}));
    const auto forward = [&](bool roulette) {
        s.plan = {.method = {.roulette = roulette}, .reference = reference};
        return s.renderer->forward(s.view, 4, {3, 0, 1}, s.config.differentiable, s.directions, s.plan, &s.result).values;
    };
    EXPECT_EQ(forward(true), forward(false));
}

// PassResult's reference: mean over the pixels of |adjoint| times the L1 norm of the derivative a camera path meets, which for an
// albedo is its derivative along ones.
TEST(PassResult, ReferenceIsTheMeanDerivative) {
    GuidedBench s("box", {"*.baseColor"}, 16);
    s.plan = {.record = true};
    s.gradient(16, {4, 0, 1});
    const double reference = s.result.reference;
    const Image forward = s.renderer->forward(s.view, 16, {4, 0, 1}, s.config.differentiable, s.ones(), s.plan, &s.result);
    double expected = 0;
    for (std::size_t p = 0; p < forward.pixels(); ++p) {
        double weight = 0, derivative = 0;
        for (int c = 0; c < 3; ++c) {
            weight += s.adjoint.values[3 * p + c] / 3;
            derivative += forward.values[3 * p + c] / 3;
        }
        expected += weight * derivative / double(forward.pixels());
    }
    EXPECT_NEAR(reference, expected, 1e-4 * expected);
}

// The measure of one pass predicts the variance over seeds: of a constant albedo that a path meets once, for random numbers without
// stratification.
TEST(PassResult, PredictsTheVarianceOverSeeds) {
    constexpr std::uint32_t kSeeds = 200, kSpp = 4;
    RenderConfig config = guidedConfig(3); // camera, wall, light: the left wall at most once but for emission
    config.sampler = Sampler::Independent;
    GuidedBench s("box", {"left.baseColor"}, 12, config);
    const double reference = s.train(3, 16);
    for (const PassPlan& plan : {PassPlan{.measure = true}, PassPlan{.method = {Sampling::Conditional}, .measure = true},
                                 PassPlan{.method = {Sampling::Primal}, .record = true},
                                 PassPlan{.method = {Sampling::Conditional, true}, .measure = true, .reference = reference},
                                 PassPlan{.method = {.roulette = true}, .measure = true, .reference = 0.1 * reference}}) {
        s.plan = plan;
        std::vector<double> variances;
        std::vector<std::vector<double>> channels(3);
        for (std::uint32_t i = 0; i < kSeeds; ++i) {
            const auto g = s.gradient(kSpp, {100 + i, 0, 1});
            variances.push_back(s.result.variance);
            for (std::size_t c = 0; c < 3; ++c)
                channels[c].push_back(g[0][c]);
        }
        double variance = 0;
        for (const auto& values : channels) {
            const double error = statistics(values).standardError;
            variance += error * error * kSeeds;
        }
        // A variance from 200 normal deviates is off by 10 % (the channels go together); later meetings count as independent.
        EXPECT_NEAR(statistics(variances).mean / variance, 1, 0.35) << "kind " << int(plan.method.kind) << (plan.method.roulette ? ", roulette" : "");
    }
}

} // namespace
} // namespace cmpg::test
