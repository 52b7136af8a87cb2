// Targets of a recovery that are averaged down.
#include "library_fixture.h"

#include <cmath>
#include <utility>

namespace cmpg::test {
namespace {

TEST(LibraryTarget, PixelsAreMeansOfWhatTheyCover) {
    Target target{.image = Image(4, 2, 3)};
    for (std::size_t i = 0; i < 24; ++i)
        target.image.values[i] = float(i / 3); // 0 1 2 3 above 4 5 6 7
    const Target half = target.averaged(2);
    EXPECT_EQ(half.image.height, 1);
    EXPECT_EQ(half.image.values, (std::vector<float>{2.5f, 2.5f, 2.5f, 4.5f, 4.5f, 4.5f}));
    EXPECT_TRUE(half.mask.empty());
    EXPECT_TRUE(half.clipped.empty());
    EXPECT_EQ(target.averaged(0, 1).image.values, half.image.values);
    EXPECT_EQ(target.averaged(4).image.values, target.image.values);
    for (const float v : Target{.image = Image(7, 5, 3, 0.3f)}.averaged(3).image.values) // uneven, and 2.14 rows
        EXPECT_NEAR(v, 0.3f, 1e-6f);

    target.mask = {0.5f, 1, 1, 1, 0.5f, 0, 1, 1};
    target.image.values[3 * 5] = NAN; // without weight
    target.image.values[3 * 3 + 1] = NAN;
    target.clipped.assign(24, 0);
    target.clipped[3 * 4 + 2] = target.clipped[3 * 5 + 1] = 1; // blue of a pixel that has weight, green of one that has none
    const Target weighted = target.averaged(2, 1);
    EXPECT_EQ(weighted.image.values, (std::vector<float>{1.5f, 1.5f, 1.5f, 5, 5, 5})); // (0.5 x 0 + 1 + 0.5 x 4) / 2, (2 + 6 + 7) / 3
    EXPECT_EQ(weighted.mask, (std::vector<float>{0.5f, 0.75f}));
    EXPECT_EQ(weighted.clipped, (std::vector<std::uint8_t>{0, 0, 1, 0, 0, 0}));

    const Target wide{.image = Image(40, 20, 3)};
    for (const auto& [width, height] : {std::pair{41, 0}, {0, 21}, {20, 20}, {40, 10}}) {
        const Error error = errorOf([&] { wide.averaged(width, height); });
        EXPECT_EQ(error.kind, ErrorKind::Input) << width << "x" << height;
        EXPECT_FALSE(error.remedy.empty());
    }
    EXPECT_EQ(errorOf([&] { target.averaged(0); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { target.averaged(-2); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { Target().averaged(2); }).kind, ErrorKind::Usage) << "it has no image";
}

TEST(LibraryTarget, StreamsStaySoWhereTheyAreAveraged) {
    const Folder folder;
    Image large(32, 16, 3);
    for (std::size_t i = 0; i < large.values.size(); ++i)
        large.values[i] = float(i % 97) / 97;
    saveImage(folder / "large.exr", large);
    const Target kept = Target::load(folder / "large.exr").averaged(8), streamed = Target::stream(folder / "large.exr").averaged(8);
    EXPECT_TRUE(streamed.image.values.empty());
    EXPECT_EQ(streamed.image.height, 4);
    EXPECT_EQ(streamed.read().image.values, kept.image.values);
}

} // namespace
} // namespace cmpg::test
