// Images: curve, formats, round trips, equal bytes, limits.
#include "gltf_writer.h"
#include "scene/file_io.h"
#include "scene/image.h"
#include "scene/jpeg_photo.h"
#include "test_images.h"

#include <cmath>
#include <limits>
#include <random>

namespace cmpg::test {
namespace {

Image ramp(int width, int height, int channels) {
    Image image(width, height, channels);
    for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = 1e-7f * float(i * i) - 3.25f;
    return image;
}

std::optional<ErrorKind> codeOf(const auto& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.kind;
    }
    return std::nullopt;
}

TEST(Srgb, IsThePiecewiseCurve) {
    EXPECT_EQ(srgbDecode(0), 0);
    EXPECT_EQ(srgbDecode(1), 1);
    EXPECT_NEAR(srgbDecode(0.04f), 0.04 / 12.92, 1e-9);             // linear part
    EXPECT_NEAR(srgbDecode(0.5f), 0.21404114048223255, 1e-7);       // ((0.5 + 0.055) / 1.055)^2.4
    EXPECT_NEAR(srgbDecode(188 / 255.0f), 0.502886458032569, 1e-6); // the code nearest to a linear half
    for (int i = 0; i < 256; ++i) EXPECT_EQ(std::lround(srgbEncode(srgbDecode(float(i) / 255)) * 255), i);
}

TEST(Exr, RoundTripIsExact) {
    const TempFolder folder;
    for (const int channels : {1, 3}) {
        Image image = ramp(37, 11, channels);
        image.values[5] = 1e30f; // no half floats
        writeExr(folder / "a.exr", image);
        const ReadImage back = readImage(folder / "a.exr");
        ASSERT_EQ(back.image.width, 37);
        ASSERT_EQ(back.image.height, 11);
        ASSERT_EQ(back.image.channels, 3);
        EXPECT_TRUE(back.clipped.empty());
        EXPECT_TRUE(back.alpha.empty());
        for (std::size_t p = 0; p < image.pixels(); ++p)
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_EQ(back.image.values[p * 3 + c], image.values[p * std::size_t(channels) + (channels == 1 ? 0 : c)]);
    }
}

TEST(Exr, EqualImagesGiveEqualBytes) {
    const TempFolder folder;
    writeExr(folder / "a.exr", ramp(64, 48, 3));
    writeExr(folder / "sub/b.exr", ramp(64, 48, 3));
    const std::string a = readText(folder / "a.exr");
    EXPECT_EQ(a, readText(folder / "sub/b.exr"));
    for (const char* word : {"capDate", "owner", "cmpg", "comments"}) EXPECT_EQ(a.find(word), std::string::npos) << word;
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2) << "nothing is left beside the files";
}

TEST(Exr, LayersKeepTheirNames) {
    const TempFolder folder;
    writeExrLayers(folder / "l.exr", {{"depth.Z", ramp(4, 4, 1)}, {"normal.X", ramp(4, 4, 1)}});
    const std::string text = readText(folder / "l.exr");
    EXPECT_NE(text.find("depth.Z"), std::string::npos);
    EXPECT_NE(text.find("normal.X"), std::string::npos);
    EXPECT_EQ(codeOf([&] { writeExrLayers(folder / "l.exr", {{"a", ramp(4, 4, 1)}, {"b", ramp(4, 5, 1)}}); }), ErrorKind::Output);
}

TEST(Exr, ReadsALayerByName) {
    const TempFolder folder;
    Image depth = ramp(2, 1, 1), x = ramp(2, 1, 1), y = ramp(2, 1, 1), z = ramp(2, 1, 1);
    y.values = {10, 20};
    z.values = {-1, -2};
    writeExrLayers(folder / "l.exr", {{"depth.Z", depth}, {"normal.X", x}, {"normal.Y", y}, {"normal.Z", z}});
    const auto layer = [&](const char* name) { return readImage(folder / "l.exr", {.maxPixels = 100, .layer = name}).image; };
    EXPECT_EQ(layer("depth").values, depth.values);
    EXPECT_EQ(layer("normal").values, (std::vector<float>{x.values[0], 10, -1, x.values[1], 20, -2}));
    EXPECT_EQ(codeOf([&] { layer("albedo"); }), ErrorKind::Input);
    EXPECT_EQ(codeOf([&] { layer(""); }), ErrorKind::Input);
}

TEST(Exr, ReadsOneChannelAndAlpha) {
    const TempFolder folder;
    saveExr(folder / "y.exr", 2, 1, "Y", {0.5f, 7});
    EXPECT_EQ(readImage(folder / "y.exr").image.values, (std::vector<float>{0.5f, 7}));
    saveExr(folder / "a.exr", 1, 1, "RGBA", {1, 2, 3, 0.25f});
    const ReadImage rgba = readImage(folder / "a.exr");
    EXPECT_EQ(rgba.image.values, (std::vector<float>{1, 2, 3}));
    EXPECT_EQ(rgba.alpha, (std::vector<float>{0.25f}));
}

// Renderers leave out the empty border of a picture, or store more than it shows: it is as large as its display window.
TEST(Exr, DataStandsInItsDisplayWindow) {
    const TempFolder folder;
    const fs::path file = folder / "w.exr";
    const Imath::Box2i picture({10, 20}, {12, 21}); // 3 x 2
    saveExr(file, picture, {{11, 21}, {11, 21}}, "RGB", {1, 2, 3});
    ReadImage image = readImage(file);
    ASSERT_EQ(image.image.width, 3);
    ASSERT_EQ(image.image.height, 2);
    EXPECT_EQ(image.image.values, (std::vector<float>{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0}));
    EXPECT_EQ(image.alpha, (std::vector<float>{0, 0, 0, 0, 1, 0})) << "what the file does not hold has no weight";
    saveExr(file, picture, {{11, 21}, {11, 21}}, "RGBA", {1, 2, 3, 0.5f});
    EXPECT_EQ(readImage(file).alpha, (std::vector<float>{0, 0, 0, 0, 0.5f, 0}));
    saveExr(file, picture, {{12, 20}, {12, 20}}, "Y", {7});
    image = readImage(file);
    EXPECT_EQ(image.image.values, (std::vector<float>{0, 0, 7, 0, 0, 0}));
    EXPECT_EQ(image.alpha, (std::vector<float>{0, 0, 1, 0, 0, 0}));
    EXPECT_EQ(readImage(file, {.layer = "Y"}).image.values, image.image.values);

    // More than it shows is cut off, on all sides or on one.
    saveExr(file, {{0, 0}, {1, 0}}, {{-1, -1}, {2, 1}}, "Y", {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
    image = readImage(file);
    EXPECT_EQ(image.image.values, (std::vector<float>{5, 6}));
    EXPECT_TRUE(image.alpha.empty());
    saveExr(file, {{0, 0}, {1, 0}}, {{1, 0}, {2, 1}}, "Y", {5, 6, 7, 8});
    image = readImage(file);
    EXPECT_EQ(image.image.values, (std::vector<float>{0, 5}));
    EXPECT_EQ(image.alpha, (std::vector<float>{0, 1}));
    saveExr(file, {{0, 0}, {1, 0}}, {{2, 0}, {3, 0}}, "Y", {5, 6});
    EXPECT_EQ(codeOf([&] { readImage(file); }), ErrorKind::Input) << "nothing of it is to be seen";

    // Both windows have the limits of all images.
    saveExr(file, {{0, 0}, {9, 9}}, {{0, 0}, {0, 0}}, "Y", {5});
    EXPECT_EQ(codeOf([&] { readImage(file, {.maxPixels = 99}); }), ErrorKind::Input);
    EXPECT_EQ(codeOf([&] { readImage(file, {.maxPixels = 100}); }), std::nullopt);
    saveExr(file, {{0, 0}, {0, 0}}, {{0, 0}, {9, 9}}, "Y", std::vector<float>(100, 1));
    EXPECT_EQ(codeOf([&] { readImage(file, {.maxPixels = 99}); }), ErrorKind::Input);
}

TEST(Png, DecodesSrgbAndMarksClippedPixels) {
    const TempFolder folder;
    savePng(folder / "a.png", 2, 1, 4, {188, 0, 0, 128, 255, 10, 20, 255});
    const ReadImage image = readImage(folder / "a.png");
    EXPECT_FLOAT_EQ(image.image.values[0], srgbDecode(188 / 255.0f));
    EXPECT_FLOAT_EQ(image.alpha[0], 128 / 255.0f);
    EXPECT_EQ(image.clipped, (std::vector<std::uint8_t>{0, 0, 0, 1, 0, 0}));
    EXPECT_FLOAT_EQ(readImage(folder / "a.png", {.linear = true}).image.values[0], 188 / 255.0f);
}

TEST(Png, WriteEncodesAndClamps) {
    const TempFolder folder;
    Image image(4, 1, 3);
    image.values = {0, 0.5f, 1, -3, 9, std::numeric_limits<float>::quiet_NaN(), 0.2f, 0.2f, 0.2f, 0.01f, 0.02f, 0.03f};
    writePng(folder / "a.png", image);
    const ReadImage back = readImage(folder / "a.png");
    ASSERT_EQ(back.image.width, 4);
    const std::vector<float> expected{0, 0.5f, 1, 0, 1, 0, 0.2f, 0.2f, 0.2f, 0.01f, 0.02f, 0.03f};
    for (std::size_t i = 0; i < expected.size(); ++i) // half a code, in sRGB
        EXPECT_NEAR(srgbEncode(back.image.values[i]), srgbEncode(expected[i]), 0.501f / 255);
}

TEST(OtherFormats, JpgAndHdr) {
    const TempFolder folder;
    const std::vector<std::uint8_t> grey(8 * 8 * 3, 100);
    stbi_write_jpg((folder / "a.jpg").c_str(), 8, 8, 3, grey.data(), 95);
    EXPECT_NEAR(readImage(folder / "a.jpg").image.values[0], srgbDecode(100 / 255.0f), 0.01); // lossy: a code or two
    const std::vector<float> bright(8 * 8 * 3, 12.0f);
    stbi_write_hdr((folder / "a.hdr").c_str(), 8, 8, 3, bright.data());
    const ReadImage hdr = readImage(folder / "a.hdr");
    EXPECT_TRUE(hdr.clipped.empty());
    EXPECT_NEAR(hdr.image.values[0], 12, 12.0 / 128); // 8-bit mantissa
    // By hand, without runs: mantissas 128, 64, 0 and exponent 129 mean 128/256 * 2, and so on; exponent 0 is black.
    const std::string flat("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\0\x81\xff\xff\xff\0", 53);
    writeText(folder / "flat.hdr", flat);
    EXPECT_EQ(readImage(folder / "flat.hdr").image.values, (std::vector<float>{1, 0.5f, 0, 0, 0, 0}));
}

TEST(ImageInput, MalformedFilesAreInputErrors) {
    const TempFolder folder;
    saveExr(folder / "good.exr", 33, 17, "RGB", std::vector<float>(33 * 17 * 3, 0.5f));
    savePng(folder / "good.png", 33, 17, 3, std::vector<std::uint8_t>(33 * 17 * 3, 9));
    stbi_write_hdr((folder / "good.hdr").c_str(), 33, 17, 3, std::vector<float>(33 * 17 * 3, 0.5f).data());
    for (const char* name : {"good.exr", "good.png", "good.hdr"}) {
        const std::string whole = readText(folder / name);
        int failures = 0;
        for (std::size_t length = 0; length < whole.size(); length += std::max<std::size_t>(whole.size() / 64, 1)) {
            writeText(folder / "cut", whole.substr(0, length));
            const std::optional<ErrorKind> code = codeOf([&] { readImage(folder / "cut"); });
            EXPECT_TRUE(code == ErrorKind::Input || code == std::nullopt) << name << " " << length;
            failures += code == ErrorKind::Input;
        }
        // Only the trailing checksum of a PNG may be cut without loss.
        EXPECT_GE(failures, 60) << name;
    }
    EXPECT_EQ(codeOf([&] { readImage(folder / "none.exr"); }), ErrorKind::Input);
    EXPECT_EQ(codeOf([&] { readImage(folder.path()); }), ErrorKind::Input);
    EXPECT_EQ(codeOf([&] { readImage("/dev/zero"); }), ErrorKind::Input);
    saveExr(folder / "nan.exr", 1, 1, "RGB", {0, std::numeric_limits<float>::quiet_NaN(), 0});
    EXPECT_EQ(codeOf([&] { readImage(folder / "nan.exr"); }), ErrorKind::Input);
    EXPECT_TRUE(std::isnan(readImage(folder / "nan.exr", {.finite = false}).image.values[1]));
    saveExr(folder / "two.exr", 1, 1, "UV", {0, 0});
    EXPECT_EQ(codeOf([&] { readImage(folder / "two.exr"); }), ErrorKind::Input);
}

TEST(ImageInput, RandomDamageNeverCrashes) {
    const TempFolder folder;
    const std::vector<std::uint8_t> codes(24 * 24 * 3, 77);
    savePng(folder / "a.png", 24, 24, 3, codes);
    stbi_write_jpg((folder / "a.jpg").c_str(), 24, 24, 3, codes.data(), 90);
    const std::vector<float> values(24 * 24 * 3, 1.5f);
    stbi_write_hdr((folder / "a.hdr").c_str(), 24, 24, 3, values.data());
    saveExr(folder / "a.exr", 24, 24, "RGB", values);
    std::mt19937 random(1);
    for (const char* name : {"a.png", "a.jpg", "a.hdr", "a.exr"}) {
        const std::string whole = readText(folder / name);
        int refused = 0;
        for (int trial = 0; trial < 1000; ++trial) {
            std::string damaged = whole;
            for (unsigned i = 0; i <= random() % 3; ++i) damaged[random() % damaged.size()] = char(random());
            writeText(folder / "x", damaged);
            const std::optional<ErrorKind> code = codeOf([&] { readImage(folder / "x", {.maxPixels = 1u << 20}); });
            ASSERT_TRUE(code == std::nullopt || code == ErrorKind::Input) << name << " trial " << trial;
            refused += code == ErrorKind::Input;
        }
        EXPECT_GT(refused, 20) << name;
    }
}

TEST(ImageInput, SizeIsCheckedFromTheHeader) {
    const TempFolder folder;
    savePng(folder / "a.png", 33, 17, 3, std::vector<std::uint8_t>(33 * 17 * 3, 9));
    std::string png = readText(folder / "a.png");
    EXPECT_EQ(codeOf([&] { readImage(folder / "a.png", {.maxPixels = 33 * 17}); }), std::nullopt);
    EXPECT_EQ(codeOf([&] { readImage(folder / "a.png", {.maxPixels = 33 * 17 - 1}); }), ErrorKind::Input);
    png[16] = 0x00, png[17] = 0x10, png[20] = 0x00, png[21] = 0x10; // IHDR: about 2^20 by 2^20
    writeText(folder / "huge.png", png);
    EXPECT_EQ(codeOf([&] { readImage(folder / "huge.png"); }), ErrorKind::Input);
    saveExr(folder / "a.exr", 2, 2, "RGB", std::vector<float>(12, 1));
    std::string exr = readText(folder / "a.exr");
    const std::size_t window = exr.find("dataWindow") + std::strlen("dataWindow") + 1 + std::strlen("box2i") + 1 + 4;
    const std::int32_t huge = 0x7ffffff0;
    for (const std::size_t side : {8u, 12u}) std::memcpy(exr.data() + window + side, &huge, 4);
    writeText(folder / "huge.exr", exr);
    EXPECT_EQ(codeOf([&] { readImage(folder / "huge.exr"); }), ErrorKind::Input);
}

TEST(ImageOutput, UnwritablePathsAreOutputErrors) {
    const TempFolder folder;
    writeText(folder / "file", "x");
    EXPECT_EQ(codeOf([&] { writeExr(folder / "file/a.exr", ramp(2, 2, 3)); }), ErrorKind::Output);
    fs::create_directories(folder / "taken.png");
    EXPECT_EQ(codeOf([&] { writePng(folder / "taken.png", ramp(2, 2, 3)); }), ErrorKind::Output);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 2) << "no half-written file is left";
}

// A segment as cameras write it, in both orders of bytes; the pictures are those of EXIF 2.3, 4.6.4.
TEST(ReadImage, TurnsPhotographsAsTheySay) {
    const TempFolder folder;
    constexpr int kWidth = 32, kHeight = 16; // quadrants: whole blocks of the code
    std::vector<std::uint8_t> codes;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            codes.push_back(std::uint8_t(40 + 60 * (x / 16) + 100 * (y / 8)));
    stbi_write_jpg((folder / "a.jpg").c_str(), kWidth, kHeight, 1, codes.data(), 100);
    const Bytes plain = readFile(folder / "a.jpg");
    const auto withOrientation = [&](int orientation, bool big) {
        Bytes tiff{std::uint8_t(big ? 'M' : 'I'), std::uint8_t(big ? 'M' : 'I')};
        const auto number = [&](std::uint32_t value, int bytes) {
            for (int i = 0; i < bytes; ++i)
                tiff.push_back(std::uint8_t(value >> 8 * (big ? bytes - 1 - i : i)));
        };
        number(42, 2), number(8, 4), number(2, 2);
        number(0x0100, 2), number(4, 2), number(1, 4), number(kWidth, 4);                        // some other tag
        number(0x0112, 2), number(3, 2), number(1, 4), number(std::uint32_t(orientation), 2), number(0, 2); // a short, in four bytes
        Bytes file = plain;
        const std::uint8_t head[] = {0xff, 0xe1, 0, std::uint8_t(2 + 6 + tiff.size()), 'E', 'x', 'i', 'f', 0, 0};
        file.insert(file.begin() + 2, tiff.begin(), tiff.end());
        file.insert(file.begin() + 2, std::begin(head), std::end(head));
        return file;
    };
    // The corners of what is shown, row by row, by their place in what is stored: 0 1 on top, 2 3 below.
    const int shown[9][4] = {{}, {0, 1, 2, 3}, {1, 0, 3, 2}, {3, 2, 1, 0}, {2, 3, 0, 1}, {0, 2, 1, 3}, {2, 0, 3, 1}, {3, 1, 2, 0}, {1, 3, 0, 2}};
    const Image stored = readImage(folder / "a.jpg").image;
    for (int orientation = 1; orientation <= 8; ++orientation)
        for (const bool big : {false, true}) {
            writeFile(folder / "b.jpg", withOrientation(orientation, big));
            const ReadImage read = readImage(folder / "b.jpg");
            const Image& image = read.image;
            ASSERT_EQ(image.width, orientation >= 5 ? kHeight : kWidth) << orientation;
            ASSERT_EQ(image.height, orientation >= 5 ? kWidth : kHeight) << orientation;
            EXPECT_EQ(read.clipped.size(), image.values.size());
            for (int corner = 0; corner < 4; ++corner) {
                const int from = shown[orientation][corner];
                EXPECT_EQ(image.at(corner % 2 * (image.width - 1), corner / 2 * (image.height - 1))[0], stored.at(from % 2 * (kWidth - 1), from / 2 * (kHeight - 1))[0])
                    << orientation << ", corner " << corner;
            }
        }
    for (const int none : {0, 9, 300}) {
        writeFile(folder / "b.jpg", withOrientation(none, false));
        EXPECT_EQ(readImage(folder / "b.jpg").image.values, stored.values) << none;
    }
    Bytes cut = withOrientation(6, true); // the directory announces more than there is
    cut[12 + 8 + 1] = 200;
    EXPECT_EQ(exifOrientation(cut), 6);
    cut[12 + 8 + 2 + 12 + 1] = 0x13; // and has no such tag
    EXPECT_EQ(exifOrientation(cut), 1);
}

// Compression takes what was clipped below the largest code.
TEST(ReadImage, CompressedHighlightsAreClipped) {
    const TempFolder folder;
    constexpr int kEdge = 64;
    std::vector<std::uint8_t> codes;
    for (int y = 0; y < kEdge; ++y)
        for (int x = 0; x < kEdge; ++x)
            for (int c = 0; c < 3; ++c) // dark stripes in an overexposed lower half
                codes.push_back(y < 32 ? std::uint8_t(100 + x + c) : (x / 3 + y / 5) % 3 == 0 ? std::uint8_t(60 + 40 * c) : 255);
    for (const int quality : {75, 90, 97}) {
        stbi_write_jpg((folder / "a.jpg").c_str(), kEdge, kEdge, 3, codes.data(), quality);
        const ReadImage read = readImage(folder / "a.jpg");
        std::size_t clipped = 0, below = 0, missed = 0;
        for (std::size_t i = 0; i < codes.size(); ++i) {
            clipped += codes[i] == 255;
            below += codes[i] == 255 && read.image.values[i] < 1;
            missed += codes[i] == 255 && !read.clipped[i];
            ASSERT_TRUE(i >= codes.size() / 2 || !read.clipped[i]) << i; // nothing there is near it
        }
        EXPECT_GT(below, clipped / 10) << quality; // the largest code alone would not do
        EXPECT_LT(missed, clipped / 50) << quality;
    }
}

} // namespace
} // namespace cmpg::test
