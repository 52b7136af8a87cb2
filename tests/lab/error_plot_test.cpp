// Plots of errors over time, and the parts of a page.
#include "lab/compare_optimize.h"
#include "imaging/html.h"
#include "lab/error_plot.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(ErrorPlot, DrawsEveryPointThatALogarithmHas) {
    ErrorPlot plot{.title = "a<b", .vertical = "error", .curves = {}, .floor = 2e-3, .floorName = "reference"};
    plot.curves.push_back({"one", {{0, 5}, {1, 1}, {10, 0.1}, {100, 0.01}}}); // the first has no place on a logarithmic axis
    plot.curves.push_back({"two & more", {{1, std::nan("")}, {2, 0.5}, {3, 0}}});
    const std::string svg = plot.svg();
    EXPECT_NE(svg.find("<title>a&lt;b</title>"), std::string::npos);
    // Pictures are made by the same calls. A straight line in both logarithms is one in the picture: in every column between two marks the
    // curve's black is where the line between its ends is.
    const Image picture = plot.picture();
    const auto rows = [&](int x, auto&& wanted) {
        std::vector<int> found;
        for (int y = 42; y < 364; ++y) // within the frame
            if (wanted(picture.at(x, y)))
                found.push_back(y);
        return found;
    };
    const auto black = [](const float* p) { return p[0] < 0.01f && p[1] < 0.01f && p[2] < 0.01f; };
    std::vector<std::pair<int, double>> middles;
    for (int x = 80; x < 555; ++x)
        if (const std::vector<int> found = rows(x, black); !found.empty())
            middles.emplace_back(x, (found.front() + found.back()) / 2.0);
    ASSERT_GT(middles.size(), 300u);
    const auto [x0, y0] = middles[10];
    const auto [x1, y1] = middles[middles.size() - 10];
    EXPECT_GT(y1, y0 + 100); // down is smaller
    for (std::size_t i = 10; i + 10 < middles.size(); ++i)
        ASSERT_NEAR(middles[i].second, y0 + (middles[i].first - x0) * (y1 - y0) / (x1 - x0), 2) << middles[i].first;
    // The only point of the other curve is a mark, and has an entry in the legend.
    int orange = 0;
    for (int x = 80; x < 555; ++x)
        orange += int(rows(x, [](const float* p) { return p[0] > 0.5f && p[2] < 0.05f; }).size());
    EXPECT_GT(orange, 12);
    EXPECT_LT(orange, 60);
}

TEST(ErrorPlot, StandsDegenerateInput) {
    for (const std::vector<std::pair<double, double>>& points :
         {std::vector<std::pair<double, double>>{}, {{1, 1}}, {{0, 0}}, {{1, 1e-300}, {2, 1e300}}, {{1, std::nan("")}}, {{1, HUGE_VAL}}}) {
        ErrorPlot plot{.title = "", .vertical = "", .curves = {{"a", points}}, .floor = std::nan(""), .floorName = ""};
        const std::string svg = plot.svg();
        EXPECT_EQ(svg.find("nan"), std::string::npos);
        EXPECT_EQ(svg.find("inf"), std::string::npos);
        EXPECT_LT(svg.size(), 100000u);
    }
}

TEST(Html, EncodesImages) {
    const std::string start = "data:image/png;base64,iVBORw0KGgo"; // the PNG signature
    for (const int width : {1, 2, 3, 4}) {
        const std::string uri = pngDataUri(Image(width, 1, 3, 0.5f));
        EXPECT_EQ(uri.rfind(start, 0), 0u);
        EXPECT_EQ((uri.size() - start.find(',') - 1) % 4, 0u);
    }
}

TEST(CompareOptimize, FindsWhenACurveGetsThere) {
    const std::vector<CurvePoint> curve = {{0, 0, 1}, {2, 1, 0.5}, {4, 2, 0.6}, {6, 3, 0.2}};
    EXPECT_EQ(secondsToReach(curve, 0.5), 2);
    EXPECT_EQ(secondsToReach(curve, 0.3), 6);
    EXPECT_FALSE(secondsToReach(curve, 0.1).has_value());
    EXPECT_DOUBLE_EQ(meanSquaredParameterError({{1, 2}, {5}}, {{1, 0}, {4}}), 5.0 / 3);
}

} // namespace
} // namespace cmpg
