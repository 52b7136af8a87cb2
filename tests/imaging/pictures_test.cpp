// Loss curves and the contact sheet.
#include "imaging/contact_sheet.h"
#include "imaging/exposure.h"
#include "imaging/loss_curve.h"
#include "scene/image_decode.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(LossCurve, ChoosesTheAxisByTheSpan) {
    const CurveAxes steep = axesOf(std::vector<double>{1, 0.1, 0.003});
    EXPECT_TRUE(steep.logarithmic);
    EXPECT_EQ(steep.ticks, (std::vector<double>{0.01, 0.1, 1}));
    EXPECT_NEAR(steep.up(0.1) - steep.up(0.01), steep.up(1) - steep.up(0.1), 1e-12);
    const CurveAxes flat = axesOf(std::vector<double>{1, 0.9, 0.8});
    EXPECT_FALSE(flat.logarithmic);
    EXPECT_EQ(flat.low, 0);
    EXPECT_EQ(flat.ticks.front(), 0);
    EXPECT_FALSE(axesOf(std::vector<double>{1, 0}).logarithmic);
}

TEST(LossCurve, StandsDegenerateInput) {
    const double nan = std::nan(""), infinite = HUGE_VAL;
    for (const std::vector<double>& loss :
         {std::vector<double>{}, {0.5}, {0, 0, 0}, {nan}, {nan, 1, nan, 2, infinite}, {1e-300, 1e300}, {-1, 1}, {0.3, 0.3}}) {
        const CurveAxes axes = axesOf(loss);
        EXPECT_LE(axes.ticks.size(), 30u);
        for (const double v : loss)
            if (std::isfinite(v)) {
                EXPECT_GE(axes.up(v), 0) << v;
                EXPECT_LE(axes.up(v), 1) << v;
            }
        const std::string svg = lossCurveSvg(loss, "t");
        EXPECT_EQ(svg.find("nan"), std::string::npos);
        EXPECT_EQ(svg.find("inf"), std::string::npos);
        Drawing drawing(Drawing::Target::Picture, 256, 256);
        drawLossCurve(drawing, 0, 0, 256, 256, loss);
    }
}

TEST(LossCurve, SvgHoldsEveryStepAndAnEscapedTitle) {
    const std::string svg = lossCurveSvg(std::vector<double>{3, 2, 1, std::nan(""), 1, 2}, "a<b & \"c\"");
    EXPECT_NE(svg.find("<title>a&lt;b &amp; &quot;c&quot;</title>"), std::string::npos);
    // The curve is broken where a value is missing: two strokes of its width and colour, of three points and of two.
    std::vector<std::ptrdiff_t> corners;
    for (std::size_t at = svg.find("stroke-width:2;"); at != std::string::npos; at = svg.find("stroke-width:2;", at + 1)) {
        const std::string path = svg.substr(svg.rfind('<', at), svg.find('>', at) - svg.rfind('<', at));
        const std::size_t data = path.find(" d=\"");
        corners.push_back(std::count(path.begin() + std::ptrdiff_t(data), path.end(), 'L'));
    }
    EXPECT_EQ(corners, (std::vector<std::ptrdiff_t>{2, 1}));
}

TEST(ContactSheet, ShowsItsPanels) {
    ContactSheet sheet;
    sheet.title = "scene.gltf";
    sheet.views.push_back({"", Image(16, 16, 3, 0.9f), Image(16, 16, 3, 0.1f), Image(16, 16, 3, 0.7f), Image(16, 16, 3, -0.2f)});
    sheet.parameters.push_back({"wall.baseColor", SlotKind::BaseColor, Image(4, 4, 3, 0.5f), Image(4, 4, 3, 0.2f), Image(4, 4, 3, 1e-4f)});
    sheet.loss = {1, 0.5, 0.1};
    const Image picture = sheet.compose();
    EXPECT_GT(picture.width, 5 * 256);
    // Middles of the panels: 256 pixels each and 12 apart.
    const int y = 30 + 18 + 128;
    EXPECT_EQ(pngCode(picture.at(12 + 128, y)[0]), pngCode(0.9f));
    EXPECT_EQ(pngCode(picture.at(12 + 268 + 128, y)[0]), pngCode(0.1f));
    EXPECT_EQ(pngCode(picture.at(12 + 2 * 268 + 128, y)[0]), pngCode(0.7f));
    EXPECT_GT(picture.at(12 + 3 * 268 + 128, y)[2], picture.at(12 + 3 * 268 + 128, y)[0]); // darker than the target, negative: blue
    const int below = y + 18 + 256 + 24 + 12;
    EXPECT_EQ(pngCode(picture.at(12 + 128, below)[0]), pngCode(0.5f));
    EXPECT_EQ(pngCode(picture.at(12 + 268 + 128, below)[0]), pngCode(0.2f));
    EXPECT_GT(picture.at(12 + 2 * 268 + 128, below)[2], picture.at(12 + 2 * 268 + 128, below)[0]); // change: negative
    EXPECT_GT(picture.at(12 + 3 * 268 + 128, below)[0], picture.at(12 + 3 * 268 + 128, below)[2]); // gradient: positive, orange
}

// Rows are as high as their pictures, with what belongs to a row right below it.
TEST(ContactSheet, ShowsWidePicturesInLowRows) {
    const auto sheetOf = [](int width, int height) {
        ContactSheet sheet;
        for (int row = 0; row < 3; ++row)
            sheet.views.push_back({"", Image(width, height, 3, 0.9f), Image(width, height, 3, 0.1f), Image(width, height, 3, 0.7f), Image(width, height, 3, -0.2f)});
        sheet.parameters.push_back({"sky", SlotKind::Radiance, Image(64, 32, 3, 0.5f), Image(64, 32, 3, 0.2f), Image(64, 32, 3, 1e-4f)});
        return sheet.compose();
    };
    EXPECT_EQ(sheetOf(64, 64).height - sheetOf(64, 32).height, 3 * 128);
    EXPECT_EQ(sheetOf(64, 64).height, sheetOf(32, 64).height);
    const Image sheet = sheetOf(64, 32);
    const int below = 30 + (18 + 128 + 24 + 12) + 18 + 64; // the middle of the second row
    EXPECT_EQ(pngCode(sheet.at(12 + 268 + 128, below)[0]), pngCode(0.1f));
    const int legend = 30 + 18 + 128 + 4 + 4;
    EXPECT_GT(sheet.at(12 + 3 * 268 + 8, legend)[2], sheet.at(12 + 3 * 268 + 8, legend)[0] + 0.2f); // its blue end
}

int darkPixels(const Image& image, int top) {
    int count = 0;
    for (int y = top; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            count += image.at(x, y)[0] < 0.1f;
    return count;
}

TEST(ContactSheet, ShowsConstantsAsNumbers) {
    ContactSheet sheet;
    sheet.views.push_back({"", Image(16, 16, 3, 0.9f), Image(16, 16, 3, 0.9f), Image(16, 16, 3, 0.9f), Image(16, 16, 3)});
    const int without = sheet.compose().height;
    sheet.parameters.push_back({"wall.roughness", SlotKind::Roughness, Image(1, 1, 1, 0.5f), Image(1, 1, 1, 0.25f), Image(1, 1, 1, 1e-3f)});
    const Image one = sheet.compose();
    EXPECT_LT(one.height, without + 100); // lines of text, no row of pictures
    EXPECT_GT(darkPixels(one, without), 100);
    for (int i = 0; i < 100; ++i)
        sheet.parameters.push_back(sheet.parameters.front());
    EXPECT_LT(sheet.compose().height, without + 500);
}

TEST(LossCurve, DrawsTheErrorAsABand) {
    const std::vector<double> loss = {1, 0.9, 0.8, 0.7}, error = {0.2, 0.2, 0.2, 0.2};
    const auto pale = [](Drawing& drawing) {
        const Image picture = drawing.picture();
        int count = 0;
        for (std::size_t p = 0; p < picture.pixels(); ++p)
            count += picture.values[3 * p] < 0.6f && picture.values[3 * p + 2] > 0.75f;
        return count;
    };
    Drawing with(Drawing::Target::Picture, 256, 256), without(Drawing::Target::Picture, 256, 256);
    drawLossCurve(with, 0, 0, 256, 256, loss, error);
    drawLossCurve(without, 0, 0, 256, 256, loss);
    EXPECT_LE(pale(without), 2 * 198); // smooth edges of the curve
    // 0.4 of an axis from 0 to 1.05, over 198 columns of 226 rows, from the first step to the last, less 0.0375 that is above the axis and a curve three pixels wide.
    EXPECT_NEAR(pale(with), (0.4 - 0.0375) / 1.05 * 226 * 198 - 3 * 198, 500);
    for (const double odd : {std::nan(""), HUGE_VAL, -1.0, 1e300}) {
        drawLossCurve(with, 0, 0, 256, 256, loss, std::vector<double>(4, odd));
        const std::string svg = lossCurveSvg(loss, "t", std::vector<double>(4, odd));
        for (const char* number : {"nan", "inf"})
            EXPECT_EQ(svg.find(number), std::string::npos) << odd;
    }
    drawLossCurve(with, 0, 0, 256, 256, loss, std::vector<double>{0.1}); // fewer than values
}

TEST(ContactSheet, ShowsDarkAndBrightScenes) {
    for (const float level : {0.001f, 50.f}) {
        ContactSheet sheet;
        sheet.views.push_back({"", Image(16, 16, 3, level), Image(16, 16, 3, level / 2), Image(16, 16, 3, level), Image(16, 16, 3)});
        const Image picture = sheet.compose();
        EXPECT_NEAR(level * exposureFor({&sheet.views[0].target}), 1, 1e-4);
        EXPECT_EQ(pngCode(picture.at(12 + 128, 176)[0]), 255);
        EXPECT_EQ(pngCode(picture.at(12 + 268 + 128, 176)[0]), pngCode(0.5f)); // one exposure for all
    }
}

TEST(ContactSheet, StandsMissingPanels) {
    EXPECT_GT(ContactSheet{}.compose().width, 0);
    ContactSheet odd;
    odd.views.push_back({"a", Image(3000, 1, 3, 0.5f), Image(1, 900, 3, std::nanf("")), Image(), Image()});
    odd.parameters.push_back({"p", SlotKind::Emission, Image(5, 3, 1, 0.5f), Image(5, 3, 1, std::nanf("")), Image(5, 3, 1, std::nanf(""))});
    odd.parameters.push_back({"q", SlotKind::Normal, Image(), Image(), Image()});
    EXPECT_GT(odd.compose().width, 0);
}

} // namespace
} // namespace cmpg
