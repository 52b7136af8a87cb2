// Textures and images of another size: what texels become.
#include "scene/resample.h"

#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

TEST(Resample, FewerTexelsAreMeansOfAreas) {
    const std::vector<float> ramp = {0, 1, 2, 3, 4, 5};
    EXPECT_EQ(resampled(ramp, 1, {6, 1}, {3, 1}, Wrap::Repeat, Wrap::Repeat), (std::vector<float>{0.5f, 2.5f, 4.5f}));
    const std::vector<float> uneven = resampled(ramp, 1, {6, 1}, {4, 1}, Wrap::Repeat, Wrap::Repeat); // one and a half texels each
    const float expected[] = {1 / 3.f, (0.5f * 1 + 2) / 1.5f, (3 + 0.5f * 4) / 1.5f, (0.5f * 4 + 5) / 1.5f};
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(uneven[i], expected[i], 1e-6f) << i;
    EXPECT_EQ(resampled(std::vector<float>{1, 10, 3, 30, 5, 50, 7, 70}, 2, {2, 2}, {1, 1}, Wrap::Repeat, Wrap::Repeat), (std::vector<float>{4, 40})) << "channels stay apart";
}

TEST(Resample, MoreTexelsAreInterpolated) {
    const std::vector<float> edge = {0, 1};
    EXPECT_EQ(resampled(edge, 1, {2, 1}, {4, 1}, Wrap::Clamp, Wrap::Clamp), (std::vector<float>{0, 0.25f, 0.75f, 1}));
    EXPECT_EQ(resampled(edge, 1, {2, 1}, {4, 1}, Wrap::Mirror, Wrap::Clamp), (std::vector<float>{0, 0.25f, 0.75f, 1}));
    EXPECT_EQ(resampled(edge, 1, {2, 1}, {4, 1}, Wrap::Repeat, Wrap::Clamp), (std::vector<float>{0.25f, 0.25f, 0.75f, 0.75f})) << "across the border";
    EXPECT_EQ(resampled(edge, 1, {1, 2}, {2, 4}, Wrap::Repeat, Wrap::Clamp), (std::vector<float>{0, 0, 0.25f, 0.25f, 0.75f, 0.75f, 1, 1}));
}

} // namespace
} // namespace cmpg::test
