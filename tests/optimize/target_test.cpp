// Targets from files: decoding, masks, exposure, refusals.
#include "base/error.h"
#include "optimize/target.h"
#include "scene/test_images.h"
#include "support/temp_folder.h"

#include <fstream>
#include <gtest/gtest.h>
#include <limits>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

class TargetFiles : public testing::Test {
  protected:
    const test::TempFolder temporary_;
    const fs::path folder_ = temporary_.path();
};

TEST_F(TargetFiles, ExrIsTakenAsItIsTimesTheExposure) {
    Image image(3, 2, 3);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(i) * 0.37f;
    writeExr(folder_ / "t.exr", image);
    EXPECT_EQ(loadTarget(folder_ / "t.exr").image.values, image.values);
    EXPECT_TRUE(loadTarget(folder_ / "t.exr").mask.empty());
    const Target brighter = loadTarget(folder_ / "t.exr", {.mask = {}, .exposure = 2});
    for (std::size_t i = 0; i < image.values.size(); ++i)
        EXPECT_FLOAT_EQ(brighter.image.values[i], 4 * image.values[i]);
}

TEST_F(TargetFiles, EightBitIsDecodedAndSaysWhatIsClipped) {
    Image image(2, 2, 3, 0.5f);
    image.values[4] = 1; // one channel of pixel 1
    image.values[6] = 0; // black is a value, not a clipped one
    writePng(folder_ / "t.png", image);
    const Target target = loadTarget(folder_ / "t.png");
    EXPECT_NEAR(target.image.values[0], 0.5f, 0.003f); // one 8-bit step of the sRGB curve there
    EXPECT_TRUE(target.mask.empty());
    EXPECT_EQ(target.clipped, (std::vector<std::uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}));
    image.values[4] = 0.9f;
    writePng(folder_ / "t.png", image);
    EXPECT_TRUE(loadTarget(folder_ / "t.png").clipped.empty());
}

// A 16-bit PNG by hand: one row of two grey pixels, not compressed.
TEST_F(TargetFiles, SixteenBitsSayWhatIsClipped) {
    const auto chunk = [](const std::string& type, const std::string& data) {
        const auto number = [](std::uint32_t v) { return std::string{char(v >> 24), char(v >> 16), char(v >> 8), char(v)}; };
        return number(std::uint32_t(data.size())) + type + data + number(0); // nobody looks at the checksum
    };
    const std::string header("\0\0\0\2\0\0\0\1\x10\0\0\0\0", 13), row("\0\xff\xff\xff\xfe", 5);
    const std::string stored = std::string("\x78\x01\x01\x05\x00\xfa\xff", 7).append(row).append(4, '\0');
    std::ofstream(folder_ / "t.png", std::ios::binary) << "\x89PNG\r\n\x1a\n" << chunk("IHDR", header) << chunk("IDAT", stored) << chunk("IEND", "");
    const Target target = loadTarget(folder_ / "t.png");
    EXPECT_EQ(target.clipped, (std::vector<std::uint8_t>{1, 1, 1, 0, 0, 0}));
    EXPECT_EQ(target.image.values[0], 1);
    EXPECT_LT(target.image.values[3], 1);
}

TEST_F(TargetFiles, PixelsThatAreNotFiniteHaveNoWeight) {
    Image image(3, 1, 3, 0.5f);
    image.values[1] = std::numeric_limits<float>::quiet_NaN();
    image.values[8] = std::numeric_limits<float>::infinity();
    writeExr(folder_ / "t.exr", image);
    const Target target = loadTarget(folder_ / "t.exr");
    EXPECT_EQ(target.mask, (std::vector<float>{0, 1, 0}));
    EXPECT_EQ(target.invalid, 2u);
    image.values.assign(9, std::numeric_limits<float>::quiet_NaN());
    writeExr(folder_ / "t.exr", image);
    EXPECT_THROW(loadTarget(folder_ / "t.exr"), Error);
}

TEST_F(TargetFiles, AlphaAndMaskMultiply) {
    std::vector<std::pair<std::string, Image>> layers;
    for (const char* name : {"R", "G", "B"})
        layers.emplace_back(name, Image(2, 2, 1, 0.25f));
    Image alpha(2, 2, 1);
    alpha.values = {1, 0.5f, 0, 1};
    layers.emplace_back("A", alpha);
    writeExrLayers(folder_ / "t.exr", layers);
    EXPECT_EQ(loadTarget(folder_ / "t.exr").mask, alpha.values);

    Image mask(2, 2, 3, 0.5f);
    mask.values[0] = mask.values[1] = mask.values[2] = 3; // beyond 1 is 1
    writeExr(folder_ / "mask.exr", mask);
    EXPECT_EQ(loadTarget(folder_ / "t.exr", {.mask = folder_ / "mask.exr", .exposure = 0}).mask, (std::vector<float>{1, 0.25f, 0, 0.5f}));
}

// A renderer that crops what is empty stores one pixel of 3 x 2.
TEST_F(TargetFiles, PixelsThatAFileLeavesOutHaveNoWeight) {
    test::saveExr(folder_ / "t.exr", {{0, 0}, {2, 1}}, {{1, 1}, {1, 1}}, "RGB", {1, 2, 3});
    const Target target = loadTarget(folder_ / "t.exr");
    ASSERT_EQ(target.image.width, 3);
    ASSERT_EQ(target.image.height, 2);
    EXPECT_EQ(target.mask, (std::vector<float>{0, 0, 0, 0, 1, 0}));
    EXPECT_EQ(std::vector<float>(target.image.values.begin() + 12, target.image.values.begin() + 15), (std::vector<float>{1, 2, 3}));
}

TEST_F(TargetFiles, RefusesMasksOfAnotherSizeAndTargetsWithNothingLeft) {
    writeExr(folder_ / "t.exr", Image(4, 3, 3, 1.f));
    writeExr(folder_ / "small.exr", Image(2, 2, 3, 1.f));
    writeExr(folder_ / "black.exr", Image(4, 3, 3, 0.f));
    for (const char* mask : {"small.exr", "black.exr"})
        try {
            loadTarget(folder_ / "t.exr", {.mask = folder_ / mask, .exposure = 0});
            FAIL() << mask;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Input);
            EXPECT_FALSE(error.remedy.empty());
        }
    EXPECT_THROW(loadTarget(folder_ / "missing.exr"), Error);
}

TEST_F(TargetFiles, OverflowingExposureDoesNotReachTheLoss) {
    Image image(2, 1, 3, 1.f);
    image.values[0] = 1e38f;
    writeExr(folder_ / "t.exr", image);
    const Target target = loadTarget(folder_ / "t.exr", {.mask = {}, .exposure = 10});
    EXPECT_EQ(target.invalid, 1u);
    EXPECT_EQ(target.mask, (std::vector<float>{0, 1}));
}

} // namespace
} // namespace cmpg
