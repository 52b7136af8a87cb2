// Pictures as PNG: the colours of their kind.
#include "live/save_picture.h"
#include "live_fixture.h"

#include "imaging/display_image.h"
#include "scene/image_decode.h"
#include "scene/image.h"

namespace cmpg::test {
namespace {

// The colour that a value has in a PNG.
Color saved(LiveColors colors, const Image& image, const LiveLook& look = {}) {
    const TempFolder scratch;
    savePicture(colors, image, scratch / "a.png", look);
    const Image picture = readImage(scratch / "a.png").image;
    return {picture.values[0], picture.values[1], picture.values[2]};
}

void expectCodes(const Color& color, const Color& expected, const char* what) {
    for (int c = 0; c < 3; ++c)
        EXPECT_EQ(pngCode(color[c]), pngCode(expected[c])) << what << ", channel " << c;
}

TEST(SavePicture, HasTheColoursOfItsKind) {
    Image color(2, 2, 3, 0.25f), scalar(2, 2, 1, 0.25f), direction(2, 2, 3);
    scalar.values[3] = 0.5f;
    for (std::size_t i = 0; i < direction.values.size(); i += 3)
        direction.values[i] = -1;
    const LiveLook exposed{.exposure = 1};
    expectCodes(saved(LiveColors::Radiance, color, exposed), {0.5f, 0.5f, 0.5f}, "radiance");
    expectCodes(saved(LiveColors::Plain, color, exposed), {0.25f, 0.25f, 0.25f}, "albedo");
    expectCodes(saved(LiveColors::Heat, scalar, {.exposure = 1, .scale = 1}), heatColor(0.25), "roughness");
    expectCodes(saved(LiveColors::Heat, scalar, exposed), heatColor(0.5), "depth");
    expectCodes(saved(LiveColors::Heat, Image(2, 2, 1), exposed), heatColor(0), "depth of nothing");
    expectCodes(saved(LiveColors::Directions, direction, exposed), {0, 0.5f, 0.5f}, "normal");
    expectCodes(saved(LiveColors::Labels, Image(2, 2, 1, 7), exposed), labelColor(7), "cell");
}

} // namespace
} // namespace cmpg::test
