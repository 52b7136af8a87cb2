// What a drawing shows of text, lines and images.
#include "base/error.h"
#include "imaging/drawing.h"
#include "imaging/fitted_image.h"
#include "scene/image_decode.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(Drawing, CharactersDiffer) {
    const auto drawn = [](const std::string& text) {
        Drawing drawing(Drawing::Target::Picture, 16, 16);
        drawing.label(2, 3, text);
        return drawing.picture().values;
    };
    std::vector<std::vector<float>> seen;
    for (char c = ' '; c < 127; ++c) {
        const std::vector<float> pixels = drawn(std::string(1, c));
        EXPECT_EQ(std::find(seen.begin(), seen.end(), pixels), seen.end()) << c;
        seen.push_back(pixels);
    }
    EXPECT_EQ(drawn(" "), Drawing(Drawing::Target::Picture, 16, 16).picture().values);
    EXPECT_EQ(drawn("\n"), drawn("?"));
    EXPECT_EQ(drawn("\xe4"), drawn("?")); // no UTF-8
    EXPECT_NE(drawn("\xc3\xa4"), drawn("?"));
}

TEST(Drawing, TextIsAsWideAsItSays) {
    const std::string text = "0.125 gradient";
    const int width = Drawing::textWidth(text, 20);
    Drawing drawing(Drawing::Target::Picture, width + 40, 40);
    drawing.label(10, 10, text, "#000000", 20);
    const Image picture = drawing.picture();
    int left = picture.width, right = 0;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if (picture.at(x, y)[0] < 0.5f) {
                left = std::min(left, x);
                right = std::max(right, x);
            }
    EXPECT_GE(left, 10);
    EXPECT_LE(left, 14);
    EXPECT_LE(right, 10 + width);
    EXPECT_GE(right, 10 + width - 6);
}

TEST(Drawing, CutsOffWhatLiesOutside) {
    Drawing drawing(Drawing::Target::Picture, 10, 6);
    drawing.image(-5, -5, 7, 7, Image(7, 7, 3));
    drawing.line(-100, 3, 100, 3, "#000000");
    drawing.label(7, 4, "wide text");
    drawing.image(4, 4, 20, 20, Image(2, 2, 3, 0.5f));
    const Image picture = drawing.picture();
    EXPECT_EQ(picture.at(1, 1)[0], 0);
    EXPECT_EQ(picture.at(2, 2)[0], 1);
    EXPECT_EQ(picture.at(9, 3)[0], 0);
}

// Each value of an image has the bytes it would have in a PNG of its own.
TEST(Drawing, ImagesKeepTheirCodes) {
    Image ramp(256, 3, 3);
    for (int y = 0; y < ramp.height; ++y)
        for (int x = 0; x < ramp.width; ++x)
            for (int c = 0; c < 3; ++c)
                ramp.at(x, y)[c] = float(x * (c + 1) + y) / 300;
    Drawing drawing(Drawing::Target::Picture, 256, 3);
    drawing.image(0, 0, 256, 3, ramp);
    const Image picture = drawing.picture();
    for (std::size_t i = 0; i < ramp.values.size(); ++i)
        ASSERT_EQ(pngCode(picture.values[i]), pngCode(ramp.values[i])) << i;
}

TEST(Drawing, RefusesWhatCairoCannotDraw) {
    try {
        Drawing(Drawing::Target::Picture, 40000, 4);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.cause.find("32767"), std::string::npos);
        EXPECT_FALSE(error.remedy.empty());
    }
}

TEST(FittedImage, KeepsTheMeanAndAspect) {
    Image ramp(64, 32, 3);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c)
                ramp.at(x, y)[c] = float(x) / 64;
    const Image fitted = fittedImage(ramp, 24, 24); // pixels of 2.67 x 2.67
    ASSERT_EQ(fitted.width, 24);
    ASSERT_EQ(fitted.height, 12);
    double sum = 0;
    for (std::size_t p = 0; p < fitted.pixels(); ++p)
        sum += double(fitted.values[3 * p + 1]);
    EXPECT_NEAR(sum / (24 * 12), 63.0 / 128, 1e-5);
    Drawing drawing(Drawing::Target::Picture, 24, 24);
    drawing.image(0, 0, 24, 24, ramp);
    EXPECT_EQ(drawing.picture().at(12, 12)[0], 1); // below it
}

} // namespace
} // namespace cmpg
