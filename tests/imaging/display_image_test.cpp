// Pictures of signed data with their legend.
#include "imaging/display_image.h"

#include "imaging/signed_colors.h"
#include "scene/image_decode.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(SignedPicture, TakesNarrowAndHighImages) {
    for (const auto& [width, height] : {std::pair{1, 256}, {3, 2000}, {1, 10000}}) {
        const Image picture = signedPicture(Image(width, height, 1, -1), 1);
        EXPECT_GE(picture.width, 128); // the legend has room
        const int zoom = (picture.height - 6 - kSignedLegendHeight) / height, middle = (picture.width - 1) / 2;
        EXPECT_GE(zoom, 1);
        EXPECT_LE(height * zoom, std::max(height, 2048));
        for (const int y : {0, height * zoom - 1})
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(pngCode(picture.at(middle, y)[c]), pngCode(signedColor(-1)[c]));
        EXPECT_EQ(picture.at(0, 0)[0], 1); // beside it
    }
}

TEST(SignedPicture, LegendTellsTheScale) {
    const auto legend = [](double scale) {
        Drawing drawing(Drawing::Target::Picture, 128, kSignedLegendHeight);
        drawSignedLegend(drawing, 0, 0, 128, scale);
        return drawing.picture().values;
    };
    EXPECT_NE(legend(0.125), legend(0.12));
    EXPECT_NE(legend(0.125), legend(0.13));
    EXPECT_EQ(legend(double(0.3f)), legend(0.3));
}

TEST(HeatScale, IsTheLargestValue) {
    Image values(2, 2, 1, -3);
    EXPECT_EQ(heatScale(values), 1);
    values.values = {0.5f, HUGE_VALF, std::nanf(""), 0.25f};
    EXPECT_EQ(heatScale(values), 0.5);
}

} // namespace
} // namespace cmpg
