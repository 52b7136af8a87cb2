// Plots of errors over time, and the parts of a page.
#include "lab/compare_optimize.h"
#include "imaging/html.h"
#include "lab/error_plot.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
        ++n;
    return n;
}

TEST(ErrorPlot, DrawsEveryPointThatALogarithmHas) {
    ErrorPlot plot{.title = "a<b", .vertical = "error", .curves = {}, .floor = 2e-3, .floorName = "reference"};
    plot.curves.push_back({"one", {{0, 5}, {1, 1}, {10, 0.1}, {100, 0.01}}}); // the first has no place on a logarithmic axis
    plot.curves.push_back({"two & more", {{1, std::nan("")}, {2, 0.5}, {3, 0}}});
    const std::string svg = plot.svg();
    EXPECT_EQ(count(svg, "<circle"), 4u);
    EXPECT_EQ(count(svg, "<path"), 2u);
    EXPECT_NE(svg.find("a&lt;b"), std::string::npos);
    EXPECT_NE(svg.find("two &amp; more"), std::string::npos);
    EXPECT_NE(svg.find("reference"), std::string::npos);
    // A straight line in both logarithms is one in the picture.
    double x[3], y[3];
    ASSERT_EQ(std::sscanf(svg.c_str() + svg.find(" d=\"") + 4, "M%lf %lfL%lf %lfL%lf %lf", x, y, x + 1, y + 1, x + 2, y + 2), 6);
    EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.2); // printed with one decimal
    EXPECT_NEAR(y[1] - y[0], y[2] - y[1], 0.2);
    EXPECT_GT(y[1], y[0]); // down is smaller
    EXPECT_EQ(svgFile(svg).rfind("<svg xmlns=\"http://www.w3.org/2000/svg\" ", 0), 0u);
}

TEST(ErrorPlot, StandsDegenerateInput) {
    for (const std::vector<std::pair<double, double>>& points :
         {std::vector<std::pair<double, double>>{}, {{1, 1}}, {{0, 0}}, {{1, 1e-300}, {2, 1e300}}, {{1, std::nan("")}}, {{1, HUGE_VAL}}}) {
        ErrorPlot plot{.title = "", .vertical = "", .curves = {{"a", points}}, .floor = std::nan(""), .floorName = ""};
        const std::string svg = plot.svg();
        EXPECT_EQ(svg.find("nan"), std::string::npos);
        EXPECT_EQ(svg.find("inf"), std::string::npos);
        EXPECT_LT(count(svg, "<text"), 60u);
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
