// The automatic choice of a method to sample.
#include "guiding/policy/sampling_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace cmpg {
namespace {

const SamplingMethod kPlain{Sampling::Bsdf, false}, kLight{Sampling::Primal, false}, kMixture{Sampling::Conditional, false},
    kSplit{Sampling::Conditional, true};

SamplingChoice allWays() { return SamplingChoice({kPlain, kLight, kMixture, kSplit}); }

const SamplingMethod kPlainSplit{Sampling::Bsdf, true}, kLightSplit{Sampling::Primal, true};

// A round of trials in which passes measure the scores `scoreOf` says. Returns the methods tried, those of the passes that only learn among them.
template <class Score> std::vector<SamplingMethod> round(SamplingChoice& choice, Score&& scoreOf) {
    std::vector<SamplingMethod> tried;
    while (const std::optional<SamplingChoice::Trial> trial = choice.trial()) {
        tried.push_back(trial->method);
        EXPECT_EQ(trial->first, tried.size() == 1);
        EXPECT_EQ(trial->measured, tried.size() == 1 || tried.size() > 3);
        choice.observe(trial->method, scoreOf(trial->method), 1);
        choice.endTrial(trial->method);
    }
    return tried;
}

TEST(SamplingChoice, LearnsThenTriesAllWaysOnce) {
    SamplingChoice choice = allWays();
    EXPECT_EQ(choice.best(), kPlain); // nothing measured
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(choice.figures(i).passes, 0u);
    EXPECT_EQ(round(choice, [](const SamplingMethod&) { return 1; }), (std::vector{kPlain, kSplit, kSplit, kSplit, kMixture, kLight}));
    EXPECT_FALSE(choice.trial());
    SamplingChoice later = allWays();
    later.restore(choice.state());
    EXPECT_FALSE(later.trial());
    EXPECT_FALSE(SamplingChoice({kMixture}).trial()); // nothing to choose
}

// Guides gain more than a factor of four: what roulette does without them is not asked.
TEST(SamplingChoice, TriesNoWayThatCannotWin) {
    const std::vector<SamplingMethod> all{kPlain, kMixture, kLight, kPlainSplit, kSplit, kLightSplit};
    const auto scores = [](double mixtureSplit) {
        return [=](const SamplingMethod& w) { return w == kPlain ? 20.0 : w == kPlainSplit ? 2.0 : w == kSplit ? mixtureSplit : w.roulette ? 1.5 : 3.0; };
    };
    SamplingChoice gains(all);
    EXPECT_EQ(round(gains, scores(1.4)), (std::vector{kPlain, kLightSplit, kLightSplit, kLightSplit, kSplit, kMixture}));
    EXPECT_EQ(gains.best(), kSplit);
    // Guides that gain less than a factor of four leave the unguided method its chance.
    SamplingChoice little(all);
    EXPECT_EQ(round(little, [](const SamplingMethod& w) { return w == kPlain ? 5.0 : w == kPlainSplit ? 0.5 : w == kSplit ? 1.4 : w.roulette ? 1.5 : 3.0; }),
              (std::vector{kPlain, kLightSplit, kLightSplit, kLightSplit, kSplit, kPlainSplit}));
    EXPECT_EQ(little.best(), kPlainSplit);
    // Here roulette makes everything worse.
    SamplingChoice loses(all);
    const auto tried = round(loses, [](const SamplingMethod& w) { return w.roulette ? 10.0 : w == kMixture ? 1.0 : 2.0; });
    EXPECT_EQ(tried.size(), 8u);
    EXPECT_EQ(loses.best(), kMixture);
}

TEST(SamplingChoice, TakesTheLeastVarianceTimesCost) {
    SamplingChoice choice = allWays();
    choice.observe(kMixture, 1, 10);
    EXPECT_EQ(choice.best(), kMixture); // the only one that is known
    choice.observe(kPlain, 3, 10);
    choice.observe(kLight, 2, 10);
    EXPECT_EQ(choice.best(), kMixture);
    choice.observe(kSplit, 0.4, 30); // less variance, dearer
    EXPECT_EQ(choice.best(), kMixture);
    choice.observe(kSplit, 0.04, 30);
    choice.observe(kSplit, 0.04, 30);
    EXPECT_EQ(choice.best(), kSplit);
    // Equal figures: the unguided pass is faster.
    SamplingChoice even({kMixture, kPlain});
    even.observe(kMixture, 1, 1);
    even.observe(kPlain, 1, 1);
    EXPECT_EQ(even.best(), kPlain);
    EXPECT_GT(even.score(0), even.score(1));
    // Nothing contributes: no reason to guide.
    SamplingChoice nothing({kPlain, kMixture});
    nothing.observe(kPlain, 0, 5);
    nothing.observe(kMixture, 0, 5);
    EXPECT_EQ(nothing.best(), kPlain);
    choice.observe({Sampling::Uniform, false}, 0, 0); // not among the methods
    EXPECT_EQ(choice.best(), kSplit);
}

TEST(SamplingChoice, GoesOnTryingTheOthers) {
    SamplingChoice choice = allWays();
    for (std::size_t i = 0; i < 4; ++i)
        choice.observe(choice.methods()[i], i == 2 ? 1 : i == 3 ? 9 : 2, 1);
    std::vector<int> tried(4, 0); // passes
    for (std::uint32_t pass = 8; pass < 1032; ++pass)
        for (std::size_t i = 0; i < 4; ++i)
            tried[i] += choice.next(pass) == choice.methods()[i];
    EXPECT_GT(tried[2], 950); // most passes by the best
    EXPECT_GE(tried[0], 5);
    EXPECT_GE(tried[1], 5);
    EXPECT_EQ(tried[3], 0); // hopeless
}

// Moments say that the mixture is best; the unguided method's passes differ less than its moments say.
TEST(SamplingChoice, BelievesRepetitionsOnceAllMeasuredWaysHaveThem) {
    SamplingChoice choice = allWays();
    for (std::size_t i = 0; i < 4; ++i)
        choice.observe(choice.methods()[i], i == 2 ? 1 : 4, 1);
    EXPECT_EQ(choice.best(), kMixture);
    choice.observeRepetition(kPlain, 0.1);
    choice.observeRepetition(kLight, 0.8);
    choice.observeRepetition(kMixture, 0.6);
    EXPECT_EQ(choice.best(), kMixture); // the last method was measured, and its ratio is not known
    SamplingChoice fewer({kPlain, kMixture, kSplit});
    fewer.observe(kPlain, 4, 1);
    fewer.observe(kMixture, 1, 1);
    fewer.observeRepetition(kPlain, 0.1);
    fewer.observeRepetition(kMixture, 0.6);
    EXPECT_EQ(fewer.best(), kPlain); // the last was not
    choice.observeRepetition(kSplit, 0.9);
    EXPECT_EQ(choice.best(), kPlain);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 0.4);
    SamplingChoice later = allWays();
    later.restore(choice.state());
    EXPECT_EQ(later.best(), kPlain);
    choice.observeRepetition(kMixture, std::numeric_limits<double>::quiet_NaN());
    choice.observeRepetition(kMixture, 0.2); // the latest counts half
    EXPECT_DOUBLE_EQ(choice.figures(2).variance, 0.4);
    choice.observe(kPlain, 4, 1, true);
    const double order = choice.figures(2).variance / choice.figures(0).variance;
    for (int i = 0; i < 40; ++i) // what drifts is the variance, not the ratios
        choice.observe(kPlain, 0.04, 1, true);
    EXPECT_NEAR(choice.figures(0).variance, 0.004, 1e-6);
    EXPECT_NEAR(choice.figures(2).variance / choice.figures(0).variance, order, 1e-6);
}

// A guide that nothing is drawn from learns in the four passes before one that may try it.
TEST(SamplingChoice, RestsWhereNoGuidePays) {
    SamplingChoice choice = allWays();
    for (std::size_t i = 0; i < 4; ++i)
        choice.observe(choice.methods()[i], i == 0 ? 1 : 2, 1);
    EXPECT_FALSE(choice.rests(20)); // the round of trials is to come
    round(choice, [](const SamplingMethod& w) { return w == kPlain ? 1 : 2; });
    std::vector<std::uint32_t> learns;
    for (std::uint32_t pass = 0; pass < 80; ++pass)
        if (!choice.rests(pass))
            learns.push_back(pass);
    EXPECT_EQ(learns, (std::vector<std::uint32_t>{0, 28, 29, 30, 31, 32, 60, 61, 62, 63, 64}));
    for (int i = 0; i < 10; ++i)
        choice.observe(kMixture, 0.1, 1);
    for (std::uint32_t pass = 0; pass < 50; ++pass)
        EXPECT_FALSE(choice.rests(pass)) << pass;
    SamplingChoice split({kPlain, {Sampling::Bsdf, true}}); // roulette goes by what the cells know
    round(split, [](const SamplingMethod& w) { return w == kPlain ? 2 : 1; });
    for (std::uint32_t pass = 0; pass < 50; ++pass)
        EXPECT_FALSE(split.rests(pass)) << pass;
}

// A ray of a guided path costs more than one of an unguided path, and so does one of a split path.
TEST(SamplingChoice, CountsWhatARayCosts) {
    const SamplingMethod split{Sampling::Bsdf, true};
    SamplingChoice choice({kPlain, kMixture, split});
    choice.observe(kPlain, 1, 5);
    choice.observe(kMixture, 0.8, 5);
    choice.observe(split, 0.4, 11);
    EXPECT_EQ(choice.best(), kPlain);
    EXPECT_NEAR(choice.score(1), 0.8 * 5 * 1.3, 1e-12);
    EXPECT_NEAR(choice.score(2), 0.4 * 11 * 1.2, 1e-12);
}

// What drifts for the method in use drifts for all: the order of the methods stays, and none looks hopeless for having been measured long ago.
TEST(SamplingChoice, KeepsTheOrderWhileTheAdjointDrifts) {
    SamplingChoice choice({kPlain, kMixture});
    choice.observe(kPlain, 3, 7);
    choice.observe(kMixture, 2, 7 / 1.3);
    for (int i = 0; i < 40; ++i)
        choice.observe(kMixture, 2e-3, 7 / 1.3, true);
    EXPECT_NEAR(choice.figures(0).variance / choice.figures(1).variance, 1.5, 1e-9);
    EXPECT_NEAR(choice.figures(1).variance, 2e-3, 1e-6);
    choice.observe(kPlain, 1e-4, 7, true); // a trial of another method is news of that method alone
    EXPECT_NEAR(choice.figures(1).variance, 2e-3, 1e-6);
    EXPECT_EQ(choice.best(), kPlain);
}

// Later passes count more, as the guide gets better; the figures follow a change.
TEST(SamplingChoice, FollowsChanges) {
    SamplingChoice choice({kPlain, kMixture});
    for (int i = 0; i < 10; ++i) {
        choice.observe(kPlain, 2, 7);
        choice.observe(kMixture, 8, 7);
    }
    EXPECT_EQ(choice.best(), kPlain);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 2);
    EXPECT_DOUBLE_EQ(choice.figures(0).rays, 7);
    for (int i = 0; i < 10; ++i)
        choice.observe(kMixture, 1, 7);
    EXPECT_EQ(choice.best(), kMixture);
    EXPECT_EQ(choice.figures(1).passes, 20u);
    EXPECT_NEAR(choice.figures(1).variance, 1, 0.1);
}

// Equal observations, equal choices; figures that were saved decide as the run that saved them.
TEST(SamplingChoice, RepeatsItself) {
    const auto run = [](SamplingChoice& choice) {
        std::vector<SamplingMethod> chosen;
        for (std::uint32_t pass = 0; pass < 100; ++pass) {
            const SamplingMethod method = choice.next(pass);
            chosen.push_back(method);
            choice.observe(method, 1.0 / (1 + pass % 7) + double(int(method.kind)) / 10, method.roulette ? 12 : 5);
        }
        return chosen;
    };
    SamplingChoice a = allWays(), b = allWays(), loaded = allWays();
    EXPECT_EQ(run(a), run(b));
    for (std::size_t i = 0; i < 4; ++i)
        loaded.setFigures(a.methods()[i], a.figures(i));
    EXPECT_EQ(loaded.best(), a.best());
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(loaded.score(i), a.score(i));
}

// Results that differ by independent normal noise of a given variance, summed over their entries.
std::vector<double> noisy(std::mt19937& random, double variance, std::size_t entries = 1000) {
    std::normal_distribution<double> noise(0, std::sqrt(variance / double(entries)));
    std::vector<double> result(entries, 3.0);
    for (double& r : result)
        r += noise(random);
    return result;
}

// Plain passes that have not yet drawn the rare paths that bring nearly everything look precise: their sizes give them away.
TEST(SamplingChoice, CountsWhatAMethodHasNotDrawnYet) {
    SamplingChoice choice({kPlain, kLight});
    const auto pass = [&](const SamplingMethod& method, double variance, double mean) {
        choice.observe(method, variance, 10);
        choice.observeMean(method, mean, 4);
    };
    pass(kPlain, 1, 1);
    pass(kLight, 3, 2); // one standard error of the difference above: may be chance
    EXPECT_EQ(choice.best(), kPlain);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 1);
    pass(kLight, 3, 11); // now 5.6 on average, of which two standard errors are not counted
    EXPECT_EQ(choice.best(), kLight);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 4 * 2.6 * 2.6);
    EXPECT_DOUBLE_EQ(choice.figures(1).variance, 3);
    pass(kPlain, 1, 1);
    choice.observe(kPlain, 1, 10, true); // what is estimated changes
    EXPECT_EQ(choice.best(), kPlain);
}

TEST(SamplingChoice, KnowsMethodsByRoughPassesUntilOthersSayMore) {
    SamplingChoice choice({kPlain, kLight});
    for (const double variance : {0.0, 900.0, 0.0, 300.0}) // a bright path now and then
        choice.observeRough(kPlain, variance, 2);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 300); // the mean of all
    EXPECT_EQ(choice.figures(0).passes, 4u);
    EXPECT_EQ(choice.best(), kPlain); // nothing else is known
    choice.observeRough(kLight, 50, 2);
    EXPECT_EQ(choice.best(), kLight);
    SamplingChoice later({kPlain, kLight});
    later.restore(choice.state());
    for (SamplingChoice* c : {&choice, &later}) {
        c->observe(kLight, 20, 2); // stands alone
        EXPECT_DOUBLE_EQ(c->figures(1).variance, 20);
        c->observeRough(kLight, 1e6, 2);
        EXPECT_DOUBLE_EQ(c->figures(1).variance, 20);
        c->observeRough(kPlain, 800, 2);
        EXPECT_DOUBLE_EQ(c->figures(0).variance, 400);
    }
    choice.setFigures(kPlain, {10, 2, 3}); // of a guide's file
    choice.observeRough(kPlain, 800, 2);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 10);
}

// Moments of single paths put the unguided method at 8, the truth is 1, as of Sobol points that do well.
TEST(SamplingChoice, BelievesDifferencesOfPassesBeforeMoments) {
    std::mt19937 random(7);
    SamplingChoice choice({kPlain, kMixture, {Sampling::Bsdf, true}, kSplit});
    const auto pass = [&](const SamplingMethod& method, double moments, double truth) {
        choice.observe(method, moments, 10);
        choice.observeResult(method, noisy(random, truth / 2), 2);
    };
    pass(kPlain, 8, 1);
    pass(kMixture, 4, 3);
    pass(kPlain, 8, 1);
    EXPECT_EQ(choice.best(), kMixture); // one pass of the other method tells no difference
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 8);
    pass(kMixture, 4, 3);
    EXPECT_EQ(choice.best(), kPlain);
    EXPECT_EQ(choice.bestKind(), Sampling::Bsdf);
    EXPECT_NEAR(choice.figures(0).variance, 1, 0.25); // 5 standard errors of 1000 squares
    EXPECT_NEAR(choice.figures(1).variance, 3, 0.75);

    choice.observeRoulette(Sampling::Bsdf, 0.5, 3); // dearer by more than it is better
    EXPECT_DOUBLE_EQ(choice.figures(2).variance, 0.5 * choice.figures(0).variance);
    EXPECT_EQ(choice.best(), kPlain);
    choice.observeRoulette(Sampling::Bsdf, 0.25, 3);
    EXPECT_EQ(choice.best(), (SamplingMethod{Sampling::Bsdf, true}));
    EXPECT_EQ(choice.bestKind(), Sampling::Bsdf);

    // What an optimisation estimates changes from step to step, and the differences with it.
    choice.observe(kPlain, 8, 10, true);
    EXPECT_DOUBLE_EQ(choice.figures(0).variance, 8);
}

TEST(PassDifferences, TellTheVarianceOfManyEntries) {
    std::mt19937 random(11);
    PassDifferences differences;
    differences.add(noisy(random, 5));
    EXPECT_FALSE(differences.variance());
    for (int i = 0; i < 6; ++i)
        differences.add(noisy(random, 5));
    ASSERT_TRUE(differences.variance());
    EXPECT_NEAR(*differences.variance(), 5, 1.25);
}

TEST(PassDifferences, SayNothingOfFewEntries) {
    std::mt19937 random(11);
    PassDifferences scalar, spike;
    for (int i = 0; i < 4; ++i) {
        scalar.add(noisy(random, 5, 3));
        std::vector<double> result = noisy(random, 1e-6);
        result[5] += i % 2;
        spike.add(result);
    }
    EXPECT_FALSE(scalar.variance());
    EXPECT_FALSE(spike.variance());
}

// Two passes whose results differ by `d` in `entries` of 100 entries: a variance of entries d^2 / 2.
PassDifferences differing(double d, std::size_t entries) {
    PassDifferences differences;
    std::vector<double> result(100, 1.0);
    differences.add(result);
    for (std::size_t i = 0; i < entries; ++i)
        result[i] += d;
    differences.add(result);
    return differences;
}

TEST(PassDifferences, TheWorseOfTwoRatios) {
    const PassDifferences small = differing(0.25, 40), large = differing(0.5, 40), unknown = differing(0.5, 2), none = differing(0, 40);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.1, small, large), 0.25);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.6, small, large), 0.6);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.6, large, small), 4);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.1, unknown, large), 0.1);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.1, small, unknown), 0.1);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.1, small, PassDifferences()), 0.1);
    EXPECT_DOUBLE_EQ(worseVarianceRatio(0.1, small, none), 0.1); // nothing to divide by
}

} // namespace
} // namespace cmpg
