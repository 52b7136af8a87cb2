// What a comparison says in one sentence.
#include "lab/compare_report.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace cmpg {
namespace {

GradientResult gradientResult(const std::string& name, double efficiency, double first, Bias::Verdict verdict = Bias::Verdict::None) {
    GradientResult r(name, 1);
    r.efficiency = {efficiency, 0.1 * efficiency};
    r.ratio = {efficiency / first, 0.1 * efficiency / first};
    r.bias.verdict = verdict;
    return r;
}

// Methods a, b, c ... of these efficiencies.
std::string headline(const std::vector<double>& efficiencies, std::size_t biased = ~std::size_t(0)) {
    GradientComparison comparison;
    for (std::size_t i = 0; i < efficiencies.size(); ++i)
        comparison.results.push_back(gradientResult(std::string(1, char('a' + i)), efficiencies[i], efficiencies[0],
                                                    i == biased ? Bias::Verdict::Biased : Bias::Verdict::None));
    return headlineOf(comparison);
}

TEST(CompareReport, SaysWhichGradientIsBest) {
    EXPECT_NE(headline({1, 3, 2}).find("<b>b</b> reaches the error of <b>a</b> in 1/3"), std::string::npos);
    EXPECT_EQ(headline({1, 0.5, 0.7}), "No other method is more efficient than <b>a</b> here.");
    EXPECT_EQ(headline({1}), "");
}

TEST(CompareReport, SaysNothingOfWhatIsNotKnown) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN(), kInfinite = std::numeric_limits<double>::infinity();
    EXPECT_EQ(headline({kNone, kNone, kNone}), "");
    EXPECT_EQ(headline({kNone, 1, 2}), "");
    EXPECT_EQ(headline({1, kNone}), "");
    EXPECT_EQ(headline({1, kInfinite}), "");
    EXPECT_NE(headline({1, kInfinite, 2}).find("<b>c</b> reaches"), std::string::npos);
    EXPECT_NE(headline({1, kNone, 2}).find("<b>c</b> reaches"), std::string::npos);
}

TEST(CompareReport, AnnouncesNothingBiased) {
    EXPECT_NE(headline({1, 3, 2}, 1).find("<b>c</b> reaches"), std::string::npos);
    EXPECT_EQ(headline({1, 3, 0.5}, 1), "No other unbiased method is more efficient than <b>a</b> here.");
    EXPECT_EQ(headline({1, 3}, 1), "");
    EXPECT_EQ(headline({1, 3}, 0), ""); // how soon the error of the first is reached says nothing
}

TEST(CompareReport, TellsOfAllRepetitionsOfARecovery) {
    OptimizeComparison comparison;
    for (const char name : {'a', 'b'})
        comparison.results.emplace_back().method.name = std::string(1, name);
    OptimizeResult &first = comparison.results[0], &other = comparison.results[1];
    first.parameterError = {0.4, 0.01};
    other.parameterError = {0.1, 0.01};
    other.ratio = {4, 0};
    other.seconds = 20;
    EXPECT_EQ(headlineOf(comparison), "<b>b</b> ends with 1/4 of the error of <b>a</b>.");
    other.repetitions = 1;
    other.secondsToFirst = {7};
    EXPECT_EQ(headlineOf(comparison), "<b>b</b> ends with 1/4 of the error of <b>a</b>, and is as good as that after 7 of its 20 seconds.");
    other.repetitions = 4;
    other.secondsToFirst = {3, 15, 5};
    EXPECT_EQ(headlineOf(comparison), "<b>b</b> ends with 1/4 of the error of <b>a</b>, and in 3 of 4 runs is as good as that after 5 of its 20 seconds.");
    other.secondsToFirst = {3, 15, 5, 4};
    EXPECT_EQ(headlineOf(comparison), "<b>b</b> ends with 1/4 of the error of <b>a</b>, and is as good as that after 4.5 of its 20 seconds.");
}

} // namespace
} // namespace cmpg
