// Signed colours, and what `view` writes.
#include "app/commands.h"
#include "imaging/signed_colors.h"
#include "command_line.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

double luminance(const Color& c) {
    return 0.2126 * double(c[0]) + 0.7152 * double(c[1]) + 0.0722 * double(c[2]);
}

TEST(SignedColors, ZeroIsNeutral) {
    const Color zero = signedColor(0);
    EXPECT_NEAR(zero[0], zero[1], 2e-3);
    EXPECT_NEAR(zero[1], zero[2], 2e-3);
    EXPECT_GT(zero[1], 0.85f); // nearly white
    EXPECT_EQ(signedColor(-0.0), zero);
}

TEST(SignedColors, SignsLookEquallyStrong) {
    double last = 2;
    for (int i = 0; i <= 100; ++i) {
        const Color above = signedColor(i / 100.0), below = signedColor(-i / 100.0);
        // Equal lightness in Oklab is not exactly equal luminance: 0.02 is a fifth of a just visible step at white.
        EXPECT_NEAR(luminance(above), luminance(below), 0.02) << i;
        EXPECT_LT(luminance(above), last) << i; // stronger is darker
        last = luminance(above);
        if (i >= 10) {
            EXPECT_GT(above[0], above[2]) << i; // orange
            EXPECT_GT(below[2], below[0]) << i; // blue
        }
    }
    EXPECT_EQ(signedColor(3), signedColor(1));
    EXPECT_EQ(signedColor(-3), signedColor(-1));
}

TEST(SignedColors, ScaleIsAPercentileRoundedUp) {
    Image values(1000, 1, 1);
    for (int i = 0; i < 1000; ++i)
        values.values[i] = (i % 2 ? 1.f : -1.f) * float(i) / 1000;
    values.values[999] = -1e6f;                  // an outlier
    EXPECT_NEAR(signedScale(values), 1.0, 1e-6); // 0.994 in two digits
    EXPECT_NEAR(signedScale(Image(1, 1, 1, -0.0123f)), 0.013, 1e-9);
    EXPECT_NEAR(signedScale(Image(1, 1, 1, 3e-4f)), 3e-4, 1e-9);
    EXPECT_EQ(signedScale(Image(4, 4, 1)), 1); // nothing but zeros
    Image sparse(100, 100, 1);
    sparse.values[17] = -2e-9f;
    EXPECT_NEAR(signedScale(sparse), 2e-9, 1e-12);
}

Options viewOptions(const std::string& input, const std::string& output) {
    Options o;
    o.command = Command::View;
    o.input = input;
    o.output = output;
    o.json = true; // keep the test's output clean
    return o;
}

TEST(View, EncodesExposedValues) {
    const test::TemporaryFolder folder;
    Image image(3, 2, 3);
    image.at(0, 0)[0] = 0.25f;
    image.at(1, 0)[1] = 5;
    image.at(2, 0)[2] = -1;
    writeExr(folder / "a.exr", image);
    Options o = viewOptions(folder / "a.exr", folder / "a.png");
    o.exposure = 1;
    Report report(o);
    EXPECT_EQ(runView(o, report), ExitStatus::Done);
    const ReadImage png = readImage(folder / "a.png");
    ASSERT_EQ(png.image.width, 3);
    ASSERT_EQ(png.image.height, 2);
    EXPECT_NEAR(png.image.at(0, 0)[0], 0.5, 0.005); // one step of 8-bit sRGB there is 0.0047
    EXPECT_EQ(png.image.at(1, 0)[1], 1);
    EXPECT_EQ(png.image.at(2, 0)[2], 0);
}

TEST(View, SignedPicturesAreSymmetric) {
    const test::TemporaryFolder folder;
    Image image(200, 4, 3);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 200; ++x)
            for (int c = 0; c < 3; ++c)
                image.at(x, y)[c] = 1e-5f * (float(x) - 99.5f);
    image.at(100, 0)[0] = image.at(100, 0)[1] = image.at(100, 0)[2] = 0;
    writeExr(folder / "a.exr", image);
    Options o = viewOptions(folder / "a.exr", folder / "a.png");
    o.isSigned = true;
    Report report(o);
    EXPECT_EQ(runView(o, report), ExitStatus::Done);
    EXPECT_NEAR(report.extra.at("scale").get<double>(), 1e-3, 1e-9);
    const Image png = readImage(folder / "a.png").image;
    ASSERT_EQ(png.width, 200);
    ASSERT_GE(png.height, 4 + kSignedLegendHeight);
    const auto lum = [&](int x, int y) { return luminance({png.at(x, y)[0], png.at(x, y)[1], png.at(x, y)[2]}); };
    for (int x = 0; x < 100; ++x)
        EXPECT_NEAR(lum(x, 1), lum(199 - x, 1), 0.03) << x; // 0.02 and the steps of 8 bits
    EXPECT_GT(png.at(0, 1)[2], png.at(0, 1)[0]);
    EXPECT_GT(png.at(199, 1)[0], png.at(199, 1)[2]);
    EXPECT_NEAR(png.at(100, 0)[0], png.at(100, 0)[2], 0.01);
    bool legend = false; // black text under the picture
    for (int y = 4; y < png.height; ++y)
        for (int x = 0; x < png.width; ++x)
            legend = legend || lum(x, y) < 0.001;
    EXPECT_TRUE(legend);
}

TEST(View, EnlargesSmallSignedImagesForTheLegend) {
    const test::TemporaryFolder folder;
    writeExr(folder / "a.exr", Image(1, 1, 3, -2e-3f));
    Options o = viewOptions(folder / "a.exr", folder / "a.png");
    o.isSigned = true;
    o.scale = 4e-3f;
    Report report(o);
    runView(o, report);
    const Image png = readImage(folder / "a.png").image;
    EXPECT_GE(png.width, 100);
    const Color half = signedColor(-0.5);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(png.at(10, 10)[c], half[c], 0.01);
}

} // namespace
} // namespace cmpg
