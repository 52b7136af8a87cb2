// Toy estimators with clocks of their own run against each other.
#include "lab/compare_runner.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace cmpg {
namespace {

constexpr std::size_t kEntries = 50;

struct ToyContestant {
    double noise = 1, seconds = 1, factor = 1; // factor: of the expected value; anything but 1 is a bias
    std::multiset<std::uint32_t> indices{};
};

Contestant contestant(const std::string& name, ToyContestant& toy, std::uint64_t stream) {
    return {name, [&toy, stream](std::uint32_t index) {
                toy.indices.insert(index);
                std::mt19937_64 random(stream << 32 | index);
                std::normal_distribution<double> normal;
                Pass pass{std::vector<double>(kEntries), toy.seconds, 100};
                for (std::size_t i = 0; i < kEntries; ++i)
                    pass.values[i] = toy.factor * (1 + double(i) / kEntries) + toy.noise * normal(random);
                return pass;
            }};
}

double truthNorm() {
    double norm = 0;
    for (std::size_t i = 0; i < kEntries; ++i)
        norm += (1 + double(i) / kEntries) * (1 + double(i) / kEntries);
    return norm;
}

TEST(CompareRunner, EfficiencyIsOneOverVarianceTimesTime) {
    ToyContestant plain{.noise = 2, .seconds = 0.5}, better{.noise = 0.5, .seconds = 0.75};
    CompareBudget budget;
    budget.seconds = 300;
    const auto comparison = compareGradients({contestant("plain", plain, 1), contestant("better", better, 2)}, kEntries, budget, {});
    for (const GradientResult& r : comparison.results) {
        EXPECT_DOUBLE_EQ(r.efficiency.value, 1 / (r.relativeVariance.value * r.seconds / double(r.statistics.passes())));
        EXPECT_DOUBLE_EQ(r.relativeVariance.value, r.statistics.variance().value / comparison.reference.reference.squaredNorm());
        const double noise = r.name == "plain" ? 2 : 0.5;
        EXPECT_NEAR(r.relativeVariance.value, kEntries * noise * noise / truthNorm(), 4 * r.relativeVariance.error);
        EXPECT_EQ(r.bias.verdict, Bias::Verdict::None);
    }
    EXPECT_EQ(comparison.results[0].ratio.value, 1);
    EXPECT_NEAR(comparison.results[1].ratio.value, 16 / 1.5, 4 * comparison.results[1].ratio.error);
    EXPECT_LT(comparison.results[1].ratio.error, 0.1 * comparison.results[1].ratio.value);
}

TEST(CompareRunner, EqualTimeIsEqualToAPass) {
    ToyContestant slow{.seconds = 0.7}, fast{.seconds = 0.2};
    CompareBudget budget;
    budget.seconds = 10;
    budget.passes = 4;
    const auto comparison = compareGradients({contestant("slow", slow, 1), contestant("fast", fast, 2)}, kEntries, budget, {});
    for (const GradientResult& r : comparison.results) {
        EXPECT_GE(r.seconds, 10);
        EXPECT_LT(r.seconds, 10 + r.secondsPerPass());
        EXPECT_EQ(r.paths, 100 * r.statistics.passes());
        EXPECT_EQ(r.curve.front().passes, 1u);
        EXPECT_EQ(r.curve.back().passes, r.statistics.passes());
        EXPECT_NEAR(r.curve.back().error, r.mse, 1e-5 * r.mse); // kept as floats
        EXPECT_EQ(r.curve.back().seconds, r.seconds);
    }
}

TEST(CompareRunner, EqualSamplesAreEqualPasses) {
    ToyContestant a{.seconds = 0.7}, b{.seconds = 0.2};
    CompareBudget budget;
    budget.passes = 9;
    const auto comparison = compareGradients({contestant("a", a, 1), contestant("b", b, 2)}, kEntries, budget, {});
    for (const GradientResult& r : comparison.results)
        EXPECT_EQ(r.statistics.passes(), 9u);
}

TEST(CompareRunner, ReferenceComesFromTheMostEfficientWithNewNumbers) {
    ToyContestant plain{.noise = 1, .seconds = 1}, best{.noise = 0.1, .seconds = 2};
    CompareBudget budget;
    budget.passes = 20;
    budget.referenceSeconds = 100;
    const auto comparison = compareGradients({contestant("plain", plain, 1), contestant("best", best, 2)}, kEntries, budget, {});
    EXPECT_EQ(comparison.reference.madeBy, "best");
    EXPECT_EQ(comparison.reference.passes, 50u); // the time is up before the goal, 200
    EXPECT_EQ(best.indices.size(), 70u);
    EXPECT_EQ(std::set<std::uint32_t>(best.indices.begin(), best.indices.end()).size(), 70u);
    EXPECT_EQ(plain.indices.size(), 20u);
    const double stated = comparison.reference.reference.relativeError();
    EXPECT_NEAR(stated, kEntries * 0.01 / 50 / truthNorm(), 0.25 * stated); // 50 x 50 samples know a variance to 3 %
}

TEST(CompareRunner, TurnsHaveTheirOwnBeginningAndFigures) {
    ToyContestant slow{.noise = 2, .seconds = 0.5}, fast{.noise = 1, .seconds = 0.25};
    std::vector<std::string> order;
    const auto turning = [&](const std::string& name, ToyContestant& toy, std::uint64_t stream) {
        Contestant c = contestant(name, toy, stream);
        c.begin = [&order, &toy, name](std::uint32_t turn) {
            order.push_back(name + std::to_string(turn));
            toy.noise = turn == 2 ? 3 : 1; // learned badly in the last one
        };
        c.end = [&order, name] { order.push_back(name); };
        c.makesReference = name == "slow";
        return c;
    };
    CompareBudget budget;
    budget.seconds = 90;
    budget.turns = 3;
    budget.referenceSeconds = 5;
    const auto comparison = compareGradients({turning("slow", slow, 1), turning("fast", fast, 2)}, kEntries, budget, {});
    const std::string reference = "slow" + std::to_string(kReferenceTurn);
    EXPECT_EQ(order, (std::vector<std::string>{"slow0", "slow", "fast0", "fast", "slow1", "slow", "fast1", "fast", "slow2", "slow", "fast2", "fast",
                                               reference, "slow"}));
    EXPECT_EQ(comparison.reference.madeBy, "slow"); // the only one that may
    for (const GradientResult& r : comparison.results) {
        ASSERT_EQ(r.turns.size(), 3u);
        EXPECT_NEAR(r.seconds, 90, 1);
        for (std::size_t turn = 0; turn < 3; ++turn) {
            const double variance = (turn == 2 ? 9.0 : 1.0) * kEntries; // 60 passes and more of 50 entries know it to 3 %
            EXPECT_NEAR(r.turns[turn].variance, variance, 0.1 * variance) << r.name << turn;
            EXPECT_DOUBLE_EQ(r.turns[turn].secondsPerPass, r.name == "slow" ? 0.5 : 0.25);
        }
    }
}

TEST(CompareRunner, BiasIsSeen) {
    ToyContestant honest{.noise = 0.5}, biased{.noise = 0.5, .factor = 1.03}, other{.noise = 0.4};
    CompareBudget budget;
    budget.passes = 400;
    const auto comparison =
        compareGradients({contestant("honest", honest, 1), contestant("biased", biased, 2), contestant("other", other, 3)}, kEntries, budget, {});
    EXPECT_EQ(comparison.reference.madeBy, "other");
    EXPECT_EQ(comparison.results[0].bias.verdict, Bias::Verdict::None);
    EXPECT_EQ(comparison.results[1].bias.verdict, Bias::Verdict::Biased);
    EXPECT_NEAR(comparison.results[1].bias.along, 0.03, 1.5 * comparison.results[1].bias.interval);
    EXPECT_EQ(comparison.results[2].bias.verdict, Bias::Verdict::None);
}

// Nothing that varies, as where all light is left out, is the most efficient of all by its figures.
TEST(CompareRunner, WhatFindsNothingIsNoReference) {
    ToyContestant nothing{.noise = 0, .seconds = 0.1, .factor = 0}, noisy{.noise = 0.5};
    CompareBudget budget;
    budget.passes = 40;
    const auto comparison = compareGradients({contestant("nothing", nothing, 1), contestant("noisy", noisy, 2)}, kEntries, budget, {});
    EXPECT_EQ(comparison.reference.madeBy, "noisy");
    EXPECT_LE(comparison.reference.seconds, 2 * (40 + 4) + 1);
    const GradientResult &zero = comparison.results[0], &other = comparison.results[1];
    EXPECT_EQ(zero.bias.verdict, Bias::Verdict::Biased);
    EXPECT_NEAR(zero.bias.along, -1, zero.bias.interval);
    EXPECT_TRUE(std::isnan(zero.efficiency.value));
    EXPECT_EQ(other.bias.verdict, Bias::Verdict::None);
    EXPECT_NEAR(other.relativeVariance.value, kEntries * 0.25 / truthNorm(), 4 * other.relativeVariance.error);
    EXPECT_GT(other.efficiency.value, 0);
    // A tenth of the error of what varies is the goal, and is reached.
    budget.referenceSeconds = 10000;
    EXPECT_LT(compareGradients({contestant("nothing", nothing, 1), contestant("noisy", noisy, 2)}, kEntries, budget, {}).reference.seconds, 800);
    EXPECT_EQ(compareGradients({contestant("nothing", nothing, 1)}, kEntries, budget, {}).reference.madeBy, "nothing");
}

TEST(CompareRunner, GivenReferenceIsTaken) {
    ToyContestant a{.noise = 1};
    Reference reference;
    for (std::size_t i = 0; i < kEntries; ++i)
        reference.values.push_back(1 + double(i) / kEntries);
    CompareBudget budget;
    budget.passes = 50;
    const auto comparison = compareGradients({contestant("a", a, 1)}, kEntries, budget, reference);
    EXPECT_EQ(comparison.reference.madeBy, "");
    EXPECT_EQ(a.indices.size(), 50u);
    EXPECT_NEAR(comparison.results[0].mse, 1.0 / 50, 0.012); // 50 entries: known to 20 %, three of them
}

} // namespace
} // namespace cmpg
