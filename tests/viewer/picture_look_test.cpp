// How values become colours in the window.
#include "viewer/picture_look.h"

#include "imaging/signed_colors.h"

#include <gtest/gtest.h>

namespace cmpg::viewer {
namespace {

LiveState stateWith(float difference, float gradient) {
    LiveState state;
    state.pictures[std::size_t(LivePicture::Image)] = std::make_shared<Image>(4, 4, 3, 0.5f);
    state.pictures[std::size_t(LivePicture::Difference)] = std::make_shared<Image>(4, 4, 3, difference);
    state.pictures[std::size_t(LivePicture::Gradient)] = std::make_shared<Image>(4, 4, 3, gradient);
    return state;
}

constexpr std::array kPictures{LivePicture::Image, LivePicture::Difference, LivePicture::Gradient};

TEST(Looks, ScalesOfSignedPictures) {
    const LiveState state = stateWith(-0.25f, 4);
    Looks looks;
    looks.update(state, kPictures);
    EXPECT_EQ(looks.of(state, LivePicture::Difference).scale, 0.25);
    EXPECT_EQ(looks.of(state, LivePicture::Gradient).scale, 4);
    looks.settings.rule = ScaleRule::Shared;
    EXPECT_EQ(looks.of(state, LivePicture::Difference).scale, 4);
    looks.settings.rule = ScaleRule::Fixed;
    looks.settings.fixedScale = 0.5f;
    EXPECT_EQ(looks.of(state, LivePicture::Gradient).scale, 0.5);
    EXPECT_EQ(looks.of(state, LivePicture::Gradient).factor, 2);
    EXPECT_EQ(looks.forFile(state, LivePicture::Gradient).scale, 0.5); // files look as the window does
}

TEST(Looks, FollowNewPictures) {
    Looks looks;
    looks.update(stateWith(1, 1), kPictures);
    const LiveState next = stateWith(1, 2);
    looks.update(next, kPictures);
    EXPECT_EQ(looks.of(next, LivePicture::Gradient).scale, 2);
}

TEST(Looks, ExposureIsForRadianceAlone) {
    LiveState state = stateWith(1, 1);
    state.pictures[std::size_t(LivePicture::Albedo)] = std::make_shared<Image>(4, 4, 3, 0.5f);
    Looks looks;
    looks.settings.exposure = 2;
    looks.update(state, kPictures);
    EXPECT_EQ(looks.of(state, LivePicture::Image).factor, 4);
    EXPECT_EQ(looks.of(state, LivePicture::Albedo).factor, 1);
    EXPECT_EQ(looks.of(state, LivePicture::Gradient).factor, 1);
    EXPECT_EQ(looks.forFile(state, LivePicture::Image).exposure, 2);
    EXPECT_EQ(colorsOf(state, LivePicture::Image), LiveColors::Radiance); // files look as the window does
    EXPECT_EQ(colorsOf(state, LivePicture::Albedo), LiveColors::Plain);
    EXPECT_EQ(colorsOf(state, LivePicture::Gradient), LiveColors::Signed);

    // A parameter by what it is of.
    constexpr std::array kParameter{LivePicture::Parameter};
    const auto shows = [&](const char* slot, int channels, float highest) {
        auto scene = std::make_shared<LiveScene>();
        scene->parameters.resize(1);
        scene->parameters[0].slot = slot;
        scene->parameters[0].highest = highest;
        state.scene = scene;
        state.settings.parameters = {0};
        state.pictures[std::size_t(LivePicture::Parameter)] = std::make_shared<Image>(4, 4, channels, 0.5f);
        looks.update(state, kParameter);
        return looks.of(state, LivePicture::Parameter);
    };
    const auto colors = [&] { return colorsOf(state, LivePicture::Parameter); };
    const auto scale = [&] { return looks.forFile(state, LivePicture::Parameter).scale; };
    EXPECT_EQ(shows("baseColor", 3, 1).factor, 1);
    EXPECT_EQ(colors(), LiveColors::Plain);
    EXPECT_EQ(shows("emission", 3, HUGE_VALF).factor, 4);
    EXPECT_EQ(colors(), LiveColors::Radiance);
    EXPECT_EQ(shows("normal", 3, 1).kind, gpu::kPanelDirection);
    EXPECT_EQ(colors(), LiveColors::Directions);
    EXPECT_EQ(shows("roughness", 1, 1).kind, gpu::kPanelScalar);
    EXPECT_EQ(colors(), LiveColors::Heat);
    EXPECT_EQ(scale(), 1); // of its range
    EXPECT_EQ(shows("scale", 1, HUGE_VALF).factor, 2);
    EXPECT_EQ(scale(), 0.5); // of its values
}

TEST(Looks, NumbersThatAreNoneDoNotCount) {
    LiveState state = stateWith(0.5f, 1);
    auto broken = std::make_shared<Image>(4, 4, 3, 0.5f);
    broken->values[7] = std::numeric_limits<float>::quiet_NaN();
    broken->values[9] = std::numeric_limits<float>::infinity();
    state.pictures[std::size_t(LivePicture::Difference)] = broken;
    Looks looks;
    looks.update(state, kPictures);
    EXPECT_EQ(looks.of(state, LivePicture::Difference).scale, 0.5);
}

} // namespace
} // namespace cmpg::viewer
