// Small files that ask for much memory or time are refused before they get it.
#include "gltf_writer.h"
#include "scene/image.h"
#include "test_images.h"

#include <ImfTiledOutputFile.h>
#include <ctime>

namespace cmpg::test {
namespace {

// What the reader says of it; "" where it reads it.
std::string refusal(const auto& read) {
    try {
        read();
        return "";
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Input);
        return e.what();
    }
}

class ImageFence : public testing::Test {
  protected:
    // The file with other bytes in one place.
    std::string changed(const std::string& name, std::size_t place, const std::string& bytes) {
        std::string file = readText(folder / name);
        file.replace(place, bytes.size(), bytes);
        writeText(folder / "changed", file);
        return refusal([&] { readImage(folder / "changed"); });
    }
    // Where an attribute's value begins, after its name, type and size.
    std::size_t attribute(const std::string& name, const std::string& type) {
        const std::size_t at = readText(folder / name.substr(0, name.find(':'))).find(name.substr(name.find(':') + 1) + '\0' + type + '\0');
        return at + name.size() - name.find(':') - 1 + 1 + type.size() + 1 + 4;
    }
    const TempFolder folder;
};

TEST_F(ImageFence, Exr) {
    saveExr(folder / "a.exr", 4, 4, "RGB", std::vector<float>(48, 1));
    const auto word = [](std::uint32_t v) { return std::string(reinterpret_cast<const char*>(&v), 4); };
    const std::size_t window = attribute("a.exr:dataWindow", "box2i");
    const auto announces = [](const std::string& message) { return message.find("announces") != std::string::npos; };
    EXPECT_EQ(changed("a.exr", window, ""), "");
    EXPECT_PRED1(announces, changed("a.exr", window + 8, word(30000) + word(15))); // its last column and line: one chunk, 5.7 MB of pixels
    EXPECT_PRED1(announces, changed("a.exr", window + 12, word(0xfffff)));
    EXPECT_PRED1(announces, changed("a.exr", attribute("a.exr:compression", "compression") - 4, word(1u << 30))); // an attribute of 1 GiB
    EXPECT_NE(changed("a.exr", window + 8, word(0x80000000)).find("no pixels"), std::string::npos);
    EXPECT_NE(changed("a.exr", 5, "\x08").find("several samples"), std::string::npos); // the flag of deep images
    const std::size_t display = attribute("a.exr:displayWindow", "box2i"); // which costs a file nothing
    EXPECT_EQ(changed("a.exr", display + 8, word(1919) + word(1079)), "");
    EXPECT_PRED1(announces, changed("a.exr", display + 8, word(8191) + word(8191))); // 1 GiB
    EXPECT_NE(changed("a.exr", display + 8, word(0x80000000)).find("cannot decode"), std::string::npos);

    Imf::Header header(4, 4);
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    header.setTileDescription(Imf::TileDescription(2, 2, Imf::ONE_LEVEL));
    std::vector<float> values(16, 1);
    {
        Imf::TiledOutputFile file((folder / "t.exr").c_str(), header);
        Imf::FrameBuffer frame;
        frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 16));
        file.setFrameBuffer(frame);
        file.writeTiles(0, 1, 0, 1);
    }
    EXPECT_EQ(changed("t.exr", 0, ""), "");
    EXPECT_PRED1(announces, changed("t.exr", attribute("t.exr:tiles", "tiledesc"), word(8192) + word(8192))); // 256 MiB for 16 pixels
}

TEST_F(ImageFence, PngJpegAndHdr) {
    savePng(folder / "a.png", 8, 8, 3, std::vector<std::uint8_t>(192, 9));
    EXPECT_NE(changed("a.png", 16, std::string("\0\0\x1f\0\0\0\x1f\0", 8)).find("announces"), std::string::npos); // 7936 x 7936
    const std::size_t data = readText(folder / "a.png").find("IDAT");
    EXPECT_NE(changed("a.png", data - 4, std::string("\x30\0\0\0", 4)).find("beyond its end"), std::string::npos);

    stbi_write_jpg((folder / "a.jpg").c_str(), 64, 64, 3, std::vector<std::uint8_t>(64 * 64 * 3, 9).data(), 50);
    const std::size_t frame = readText(folder / "a.jpg").find("\xff\xc0") + 5;
    EXPECT_NE(changed("a.jpg", frame, "\x20\x01\x20\x01").find("announces"), std::string::npos); // 8193 x 8193
    const std::string jpeg = readText(folder / "a.jpg");
    const std::size_t scan = jpeg.find("\xff\xda");
    std::string scans = jpeg.substr(0, jpeg.size() - 2);
    while (scans.size() < (std::size_t(14) << 18) + jpeg.size()) scans += jpeg.substr(scan, 14); // its header alone: over 2^18 times the 2^12 pixels
    writeText(folder / "scans.jpg", scans + jpeg.substr(jpeg.size() - 2));
    EXPECT_NE(refusal([&] { readImage(folder / "scans.jpg"); }).find("scans"), std::string::npos);
    const std::size_t huffman = jpeg.find("\xff\xc4"); // the tables that a scan names are there, and no longer than they can be
    EXPECT_NE(changed("a.jpg", huffman + 1, "\xe0").find("Huffman table is missing"), std::string::npos);
    EXPECT_NE(changed("a.jpg", huffman + 5, std::string(16, '\xff')).find("256 symbols"), std::string::npos);
    EXPECT_NE(changed("a.jpg", jpeg.find("\xff\xdb") + 1, "\xe0").find("quantisation table is missing"), std::string::npos);

    writeText(folder / "a.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8000 +X 8000\n");
    EXPECT_NE(refusal([&] { readImage(folder / "a.hdr"); }).find("announces"), std::string::npos);
}

TEST(SceneLimits, InstancesAndSharedAccessors) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    for (int i = 0; i < 10; ++i) w.json["meshes"][0]["primitives"].push_back(w.json["meshes"][0]["primitives"][0]); // 11 in all
    for (int i = 1; i < 10; ++i) {
        w.json["nodes"].push_back({{"mesh", 0}});
        w.json["scenes"][0]["nodes"].push_back(i);
    }
    const fs::path file = w.write(folder);
    EXPECT_EQ(loadScene(file, {.maxTriangles = 110}).geometry.triangles.size(), 110u);
    EXPECT_NE(refusal([&] { loadScene(file, {.maxTriangles = 109}); }).find("109 triangles"), std::string::npos);
    // Vertices that no triangle uses are read, too.
    primitive(w)["indices"] = w.indices({0, 0, 0});
    primitive(w)["attributes"] = {{"POSITION", w.floats(std::vector<float>(3 * 400), 3)}};
    const fs::path unused = w.write(folder);
    EXPECT_NE(refusal([&] { loadScene(unused, {.maxTriangles = 200}); }).find("vertices"), std::string::npos);
}

TEST(SceneLimits, TexturesSharedByMaterials) {
    const TempFolder folder;
    savePng(folder / "a.png", 16, 16, 4, std::vector<std::uint8_t>(1024, 9));
    GltfWriter w = oneTriangle();
    w.json["images"] = {{{"uri", "a.png"}}};
    w.json["textures"] = {{{"source", 0}}};
    for (int i = 0; i < 3; ++i)
        w.json["materials"].push_back({{"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}); // 768 bytes and 256
    const fs::path file = w.write(folder);
    EXPECT_EQ(refusal([&] { loadScene(file, {.maxTextureBytes = 3072}); }), "");
    EXPECT_NE(refusal([&] { loadScene(file, {.maxTextureBytes = 3071}); }).find("textures are too large"), std::string::npos);
}

// Time proportional to the file: 40 000 likes took a minute when each tried all numbers, and take about a second. Processor time: others' work is none of it.
TEST(SceneLimits, EqualNames) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    w.json["materials"] = Json::array();
    for (int i = 0; i < 40000; ++i) w.json["materials"].push_back({{"name", i == 2 ? "a#2" : "a"}, {"alphaMode", "BLEND"}});
    const fs::path file = w.write(folder);
    const std::clock_t begin = std::clock();
    const Scene scene = loadScene(file);
    EXPECT_LT(double(std::clock() - begin) / CLOCKS_PER_SEC, 5.0);
    EXPECT_EQ(scene.materials[1].name, "a#2");
    EXPECT_EQ(scene.materials[2].name, "a#2#2");
    EXPECT_EQ(scene.materials[39999].name, "a#39999");
}

} // namespace
} // namespace cmpg::test
