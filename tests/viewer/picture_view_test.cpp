// Zoom, pan and the arrangement of panels.
#include "viewer/layout.h"
#include "viewer/picture_view.h"

#include <gtest/gtest.h>
#include <random>

namespace cmpg::viewer {
namespace {

const Rectangle kArea{310, 25, 377, 412};

// Where a point of the picture, in units of its extent, stands in the window, before rounding to whole pixels.
glm::dvec2 onScreen(const PictureView& view, glm::dvec2 point, int width, int height) {
    const Rectangle place = placeOf(view, width, height, kArea);
    return glm::dvec2(place.x, place.y) + point * glm::dvec2(place.width, place.height);
}

TEST(PictureView, FitsAtFirst) {
    for (const auto& [width, height] : {std::pair{256, 256}, {512, 288}, {64, 1024}, {1, 1}, {4096, 3}}) {
        const Rectangle place = placeOf({}, width, height, kArea);
        EXPECT_GE(place.x, kArea.x - 1);
        EXPECT_GE(place.y, kArea.y - 1);
        EXPECT_LE(place.right(), kArea.right() + 1);
        EXPECT_LE(place.bottom(), kArea.bottom() + 1);
        EXPECT_NEAR(std::min(kArea.width - place.width, kArea.height - place.height), 0, 0.01) << width << "x" << height;
    }
}

TEST(PictureView, ActualSizeIsExact) {
    PictureView view;
    showActualSize(view, 256, 192, kArea);
    const Rectangle place = placeOf(view, 256, 192, kArea);
    EXPECT_EQ(place.width, 256);
    EXPECT_EQ(place.height, 192);
    EXPECT_EQ(place.x, std::round(place.x));
    EXPECT_EQ(pixelAt({place.x + 0.5f, place.y + 0.5f}, 256, 192, place), glm::ivec2(0, 0));
    EXPECT_EQ(pixelAt({place.x + 255.5f, place.y + 191.5f}, 256, 192, place), glm::ivec2(255, 191));
    EXPECT_FALSE(pixelAt({place.x - 0.5f, place.y + 3}, 256, 192, place));
    EXPECT_FALSE(pixelAt({place.x + 256.5f, place.y + 3}, 256, 192, place));
}

TEST(PictureView, ZoomKeepsWhatIsUnderTheCursor) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> unit(0.25, 0.75);
    for (int i = 0; i < 100; ++i) {
        PictureView view;
        const glm::dvec2 point(unit(random), unit(random));
        const glm::dvec2 cursor = onScreen(view, point, 512, 288);
        for (int step = 0; step < 8; ++step) {
            zoomAbout(view, 1.3, glm::vec2(cursor), 512, 288, kArea);
            // The place is rounded to whole pixels.
            EXPECT_LT(glm::length(onScreen(view, point, 512, 288) - cursor), 1.5) << i << ", " << step;
        }
    }
}

TEST(PictureView, ZoomHasLimits) {
    PictureView view;
    for (int i = 0; i < 200; ++i)
        zoomAbout(view, 1.5, {400, 200}, 100, 100, kArea);
    EXPECT_LE(placeOf(view, 100, 100, kArea).width, 100 * 129);
    for (int i = 0; i < 200; ++i)
        zoomAbout(view, 0.5, {400, 200}, 100, 100, kArea);
    EXPECT_GE(placeOf(view, 100, 100, kArea).width, 20);
}

TEST(PictureView, PanMovesByPixels) {
    PictureView view;
    view.zoom = 4;
    const glm::dvec2 before = onScreen(view, {0.5, 0.5}, 512, 288);
    panBy(view, {37, -21}, 512, 288, kArea);
    const glm::dvec2 moved = onScreen(view, {0.5, 0.5}, 512, 288) - before;
    EXPECT_NEAR(moved.x, 37, 1);
    EXPECT_NEAR(moved.y, -21, 1);
    panBy(view, {1e6f, 1e6f}, 512, 288, kArea); // something of the picture stays in the panel
    EXPECT_GE(view.center.x, 0);
    EXPECT_GE(view.center.y, 0);
}

TEST(Layout, TilesShareTheAreaWithoutOverlap) {
    for (const float aspect : {0.4f, 1.f, 2.2f})
        for (std::size_t count = 1; count <= 11; ++count) {
            const std::vector<Rectangle> all = tiles({300, 12, 1120, 700}, count, aspect, 42, 9);
            ASSERT_EQ(all.size(), count);
            for (std::size_t i = 0; i < count; ++i) {
                EXPECT_GE(all[i].x, 300);
                EXPECT_GE(all[i].y, 12);
                EXPECT_LE(all[i].right(), 1420.01);
                EXPECT_LE(all[i].bottom(), 712.01);
                for (std::size_t j = 0; j < i; ++j)
                    EXPECT_TRUE(all[j].right() <= all[i].x || all[j].bottom() <= all[i].y || all[i].right() <= all[j].x) << i << " and " << j;
            }
        }
}

TEST(Layout, WidePicturesStandOverEachOther) {
    const auto wide = tiles({0, 0, 1000, 1000}, 2, 3, 40, 8), tall = tiles({0, 0, 1000, 1000}, 2, 0.4f, 40, 8);
    EXPECT_EQ(wide[0].x, wide[1].x);
    EXPECT_EQ(tall[0].y, tall[1].y);
}

} // namespace
} // namespace cmpg::viewer
