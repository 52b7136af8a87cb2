// Figures of merit on estimators whose variance and bias are known.
#include "lab/estimate_statistics.h"
#include "base/student_t.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

constexpr std::size_t kEntries = 200;

// An estimator of truth() with normal noise: standard deviation `noise` in every entry, and `common` along all of them together.
struct Toy {
    double noise = 1, common = 0;
    std::vector<double> bias = std::vector<double>(kEntries);

    std::vector<double> draw(std::mt19937_64& random) const;
    EstimateStatistics run(std::uint64_t passes, std::mt19937_64& random) const {
        EstimateStatistics statistics(kEntries);
        for (std::uint64_t i = 0; i < passes; ++i)
            statistics.add(draw(random));
        return statistics;
    }
};

std::vector<double> truth() {
    std::vector<double> values(kEntries);
    for (std::size_t i = 0; i < kEntries; ++i)
        values[i] = std::sin(0.1 * double(i)) + 0.3;
    return values;
}

std::vector<double> Toy::draw(std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    std::vector<double> values = truth();
    const double shift = common * normal(random);
    for (std::size_t i = 0; i < kEntries; ++i)
        values[i] += bias[i] + shift + noise * normal(random);
    return values;
}

double squaredNorm(const std::vector<double>& values) { return squaredDistance(values, std::vector<double>(values.size())); }

Reference exactReference() { return {truth(), {}, 0}; }

TEST(EstimateStatistics, MeanAndVarianceAreThoseOfAllPasses) {
    std::mt19937_64 random(1);
    const Toy toy{.noise = 0.5};
    EstimateStatistics statistics(kEntries);
    std::vector<std::vector<double>> passes;
    for (int k = 0; k < 77; ++k) {
        passes.push_back(toy.draw(random));
        statistics.add(passes.back());
    }
    std::vector<double> mean(kEntries);
    for (const auto& pass : passes)
        for (std::size_t i = 0; i < kEntries; ++i)
            mean[i] += pass[i] / 77;
    double variance = 0;
    for (const auto& pass : passes)
        variance += squaredDistance(pass, mean) / 76;
    EXPECT_NEAR(statistics.variance().value, variance, 1e-9 * variance);
    EXPECT_LT(squaredDistance(statistics.mean(), mean), 1e-20);
    EXPECT_EQ(statistics.passes(), 77u);
}

// The error a variance is given with is the spread of such variances.
TEST(EstimateStatistics, VarianceKnowsItsOwnError) {
    std::mt19937_64 random(2);
    for (const double common : {0.0, 1.0}) {
        const Toy toy{.noise = 1, .common = common};
        const double expected = kEntries * (1 + common * common);
        double sum = 0, squares = 0, stated = 0;
        constexpr int kRuns = 300;
        for (int run = 0; run < kRuns; ++run) {
            const Uncertain variance = toy.run(40, random).variance();
            sum += variance.value / kRuns;
            squares += (variance.value - expected) * (variance.value - expected) / kRuns;
            stated += variance.error * variance.error / kRuns;
        }
        EXPECT_NEAR(sum, expected, 4 * std::sqrt(squares / kRuns));
        // 300 runs know a variance to 8 % (normal) or 20 % (one direction dominates: heavier tails); three of these.
        EXPECT_NEAR(stated / squares, 1, common == 0 ? 0.25 : 0.6) << common;
    }
}

TEST(EstimateStatistics, KeepsFewBatchesOfEqualSize) {
    std::mt19937_64 random(3);
    for (const std::uint64_t passes : {1, 15, 31, 32, 33, 64, 1000}) {
        EstimateStatistics statistics(1);
        for (std::uint64_t k = 0; k < passes; ++k)
            statistics.add(std::vector<double>{double(k)});
        const std::size_t batches = statistics.batches().size();
        EXPECT_LT(batches, EstimateStatistics::kBatches);
        EXPECT_GE(batches, std::min<std::uint64_t>(passes, EstimateStatistics::kBatches / 2));
        // Consecutive passes of equal numbers: batch b holds size * b ... size * (b + 1) - 1.
        const double size = batches > 1 ? double(statistics.batches()[1][0] - statistics.batches()[0][0]) : 1;
        for (std::size_t b = 0; b < batches; ++b)
            EXPECT_FLOAT_EQ(statistics.batches()[b][0], float(size * double(b) + (size - 1) / 2)) << passes;
    }
}

// The error against a noisy reference is that against the truth.
TEST(EstimateStatistics, ErrorsLeaveTheReferencesOwnOut) {
    std::mt19937_64 random(7);
    double sum = 0;
    constexpr int kRuns = 100;
    for (int run = 0; run < kRuns; ++run)
        sum += meanSquaredError(Toy{.noise = 1}.run(10, random).mean(), referenceOf(Toy{.noise = 1}.run(20, random))) / kRuns;
    EXPECT_NEAR(sum, 0.1, 0.004); // 100 x 200 entries: known to 1 %, and as much from the reference; three of them
}

// 95 % intervals along the reference leave the truth out once in twenty, whether or not the reference has an error of its own.
TEST(Bias, IntervalsCoverAsTheySay) {
    std::mt19937_64 random(4);
    for (const bool exact : {true, false}) {
        constexpr int kRuns = 1000;
        int outside = 0, called = 0;
        double sum = 0, squares = 0;
        for (int run = 0; run < kRuns; ++run) {
            const Toy toy{.noise = 1, .common = 0.1};
            const Reference reference = exact ? exactReference() : referenceOf(toy.run(40, random));
            const Bias bias = biasOf(toy.run(24, random), reference);
            outside += std::abs(bias.along) > bias.interval;
            called += bias.verdict == Bias::Verdict::Biased;
            sum += bias.z() / kRuns;
            squares += bias.z() * bias.z() / kRuns;
        }
        // 50 expected with a standard deviation of 7; three of them. Batches differ a little in number from the passes.
        EXPECT_NEAR(outside, 50, 21) << exact;
        EXPECT_LE(called, 8) << exact; // 1 at the level of 0.1 %, and few from the second statistic
        EXPECT_NEAR(sum, 0, 0.15) << exact;       // 1 / sqrt(1000) each; five of them
        EXPECT_NEAR(squares, 1, 0.35) << exact;   // unit variance; skewed, hence wide
    }
}

// Sixteen passes of which most miss a path that one in fifty meets: no bias, though they are alike.
TEST(Bias, IsNotCalledWhereFewPassesMissRarePaths) {
    std::mt19937_64 random(8);
    std::bernoulli_distribution meets(0.02);
    std::normal_distribution<double> noise(0, 0.01);
    int called = 0;
    constexpr int kRuns = 2000;
    for (int run = 0; run < kRuns; ++run) {
        EstimateStatistics statistics(kEntries);
        for (int pass = 0; pass < 16; ++pass) {
            std::vector<double> values = truth();
            const double factor = 1 + noise(random) + 0.27 * (meets(random) - 0.02);
            for (double& v : values)
                v = v * factor + 10 * noise(random); // most of the noise is not along the truth
            statistics.add(values);
        }
        called += biasOf(statistics, exactReference()).verdict == Bias::Verdict::Biased;
    }
    EXPECT_LE(called, 10); // at the level of many passes 29 are
}

TEST(Bias, FindsAndMeasuresWhatIsThere) {
    std::mt19937_64 random(5);
    Toy longer{.noise = 0.3};
    for (std::size_t i = 0; i < kEntries; ++i)
        longer.bias[i] = 0.05 * truth()[i];
    const Bias along = biasOf(longer.run(400, random), exactReference());
    EXPECT_EQ(along.verdict, Bias::Verdict::Biased);
    EXPECT_NEAR(along.along, 0.05, 1.5 * along.interval); // three standard errors
    EXPECT_NEAR(along.squared, 0.05 * 0.05, 5 * along.squaredError + 0.0005);

    // Across the reference: nothing along it, all of it anywhere.
    Toy across{.noise = 0.3};
    for (std::size_t i = 0; i < kEntries; ++i)
        across.bias[i] = i % 2 == 0 ? 0.05 : -0.05;
    const Bias anywhere = biasOf(across.run(400, random), exactReference());
    EXPECT_EQ(anywhere.verdict, Bias::Verdict::Biased);
    EXPECT_LT(std::abs(anywhere.along), 2 * anywhere.interval);
    const double expected = squaredNorm(across.bias) / squaredNorm(truth());
    EXPECT_NEAR(anywhere.squared, expected, 0.3 * expected);
}

// A deviation across a reference whose error is larger than the deviation is not held against the method.
TEST(Bias, IsNotCalledBelowTheReferencesError) {
    std::mt19937_64 random(6);
    const Reference reference = referenceOf(Toy{.noise = 0.4}.run(20, random));
    const auto biasAcross = [&](double share) { // of the reference's squared error
        Toy toy{.noise = 0.05};
        const double entry = std::sqrt(share * reference.variance / kEntries);
        for (std::size_t i = 0; i < kEntries; ++i)
            toy.bias[i] = i % 2 == 0 ? entry : -entry;
        return biasOf(toy.run(400, random), reference);
    };
    const Bias below = biasAcross(0.75);
    EXPECT_GT(below.z(), 5); // 7.5 expected, known to 1
    EXPECT_LT(below.squared, reference.relativeError());
    EXPECT_EQ(below.verdict, Bias::Verdict::BelowReference);
    EXPECT_EQ(biasAcross(1.5).verdict, Bias::Verdict::Biased);
    EXPECT_EQ(biasAcross(0).verdict, Bias::Verdict::None);
}

TEST(Bias, StandsDegenerateInput) {
    const EstimateStatistics empty(3);
    EXPECT_TRUE(std::isnan(biasOf(empty, Reference{{1, 2, 3}, {}, 0}).along));
    EstimateStatistics zeros(3);
    for (int k = 0; k < 8; ++k)
        zeros.add(std::vector<double>(3));
    EXPECT_TRUE(std::isnan(biasOf(zeros, referenceOf(zeros)).along)); // nothing to be relative to
    EstimateStatistics constant(3);
    for (int k = 0; k < 8; ++k)
        constant.add(std::vector<double>{1, 2, 3});
    EXPECT_EQ(biasOf(constant, Reference{{1, 2, 3}, {}, 0}).verdict, Bias::Verdict::None);
    EXPECT_EQ(biasOf(constant, Reference{{1, 2, 3.1}, {}, 0}).verdict, Bias::Verdict::Biased);
}

TEST(StudentT, QuantilesInvertTheDistribution) {
    for (const double degrees : {1.0, 3.0, 15.5, 1e6})
        for (const double probability : {0.5, 0.05, 0.001})
            EXPECT_NEAR(studentTwoSided(studentQuantile(probability, degrees), degrees), probability, 1e-9);
    EXPECT_NEAR(studentQuantile(0.05, 1e7), 1.95996, 1e-4);
}

} // namespace
} // namespace cmpg
