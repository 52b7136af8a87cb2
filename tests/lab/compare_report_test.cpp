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

} // namespace
} // namespace cmpg
