// Names of the files that an export writes.
#include "gltf_writer.h"
#include "scene/export_folder.h"
#include "scene/file_io.h"
#include "scene/image.h"
#include "test_images.h"

#include <set>

namespace cmpg::test {
namespace {

TEST(ExportFolder, FileNamesAreSafe) {
    EXPECT_EQ(fileName("wall.baseColor"), "wall.baseColor");
    EXPECT_EQ(fileName("../a/b\n.normal").find_first_of("/\\\n"), std::string::npos);
    EXPECT_NE(fileName("a/b.normal"), fileName("a:b.normal")); // no two parameters share a file
    EXPECT_EQ(fileName("Wall (2) #3_a-b%.baseColor"), "Wall (2) #3_a-b%25.baseColor");
    EXPECT_EQ(fileName("a~b*?\"<>|\\\x7f.normal"), "a%7Eb%2A%3F%22%3C%3E%7C%5C%7F.normal");
    EXPECT_EQ(fileName(".hidden.normal"), "%2Ehidden.normal");
}

TEST(ExportFolder, FileNamesKeepLetters) {
    EXPECT_EQ(fileName("Wände.baseColor"), "Wände.baseColor");
    EXPECT_EQ(fileName("木の床 🪵.baseColor"), "木の床 🪵.baseColor");
    EXPECT_EQ(fileName("a\xff\xc3.normal"), "a%FF%C3.normal") << "no UTF-8";
    EXPECT_EQ(fileName("\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80"), "%C0%AF%ED%A0%80%F4%90%80%80") << "a longer form, half a pair, beyond the last";
    EXPECT_EQ(fileName("a\u0085\u202e\u200b\ufeff.normal"), "a%C2%85%E2%80%AE%E2%80%8B%EF%BB%BF.normal") << "not to be seen";
}

TEST(ExportFolder, FileNamesAreShort) {
    constexpr std::size_t kMost = 120;
    const std::string many(110, 'x');
    EXPECT_EQ(fileName(many + ".baseColor"), many + ".baseColor");
    std::set<std::string> names;
    for (const std::string& beginning : {std::string(300, 'x'), std::string(300, 'x') + "y", std::string(50, '/'), std::string(50, '!') + '/'})
        for (const char* slot : {".baseColor", ".normal"}) {
            const std::string name = fileName(beginning + slot);
            EXPECT_LE(name.size(), kMost) << name;
            EXPECT_TRUE(name.ends_with(slot)) << name;
            EXPECT_EQ(std::count(name.begin(), name.end(), '%') * 3 + std::count(name.begin(), name.end(), 'x') + 17 + std::ptrdiff_t(std::strlen(slot)),
                      std::ptrdiff_t(name.size())) << "whole codes: " << name;
            names.insert(name);
        }
    EXPECT_EQ(names.size(), 8u);
    for (std::size_t shift = 0; shift < 4; ++shift) { // cut between characters
        std::string name(shift, 'x');
        for (int i = 0; i < 100; ++i) name += "床";
        const std::string cut = fileName(name + ".baseColor");
        EXPECT_LE(cut.size(), kMost);
        EXPECT_EQ((cut.find('~') - shift) % 3, 0u) << cut;
    }
    EXPECT_LE(fileName("a." + std::string(400, 'z')).size(), kMost);
}

TEST(ExportFolder, LongNamesAreWritten) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    std::string name;
    for (int i = 0; i < 80; ++i) name += "床"; // 240 bytes, and 720 percent-encoded
    w.json["materials"] = {{{"name", name}}};
    primitive(w)["material"] = 0;
    Scene s = loadScene(w.write(folder));
    const std::uint32_t index = s.parameter(name + ".baseColor");
    s.parameters[index].values = {0.25f, 0.5f, 0.75f};
    const TempFolder out;
    exportScene(s, {index}, out.path());
    EXPECT_EQ(readImage(out / ("parameters/" + fileName(name + ".baseColor") + ".exr")).image.values, s.parameters[index].values);
    EXPECT_EQ(valuesOf(loadScene(out / "scene.gltf"), name + ".baseColor"), s.parameters[index].values);

    // As long as a name may be, though it is written under another one first.
    const fs::path file = out / (std::string(251, 'x') + ".txt");
    const std::uint8_t byte = 'a';
    writeFile(file, std::span(&byte, 1));
    EXPECT_EQ(readText(file), "a");
}

} // namespace
} // namespace cmpg::test
