// Bad input as users come across it: each case ends with its documented exit code and a message that helps, and leaves no result.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>
#include <limits>

namespace cmpg {
namespace {

using test::runProgram;
namespace fs = std::filesystem;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf"; // painting.baseColor has 64x64 texels
const std::string kFurnace = CMPG_SOURCE_DIR "/scenes/furnace/scene.gltf";

struct Case {
    std::vector<std::string> arguments;
    int code;
    std::string says; // part of the message on stderr
};

// The first `part` of a file.
void truncate(const std::string& from, const std::string& to, double part) {
    const std::string bytes = test::readText(from);
    ASSERT_FALSE(bytes.empty()) << from;
    test::writeText(to, bytes.substr(0, std::size_t(double(bytes.size()) * part)));
}

class BadInput : public testing::Test {
  protected:
    void SetUp() override {
        writeExr(good, Image(16, 16, 3, 0.5f));
        writeExr(large, Image(20, 12, 3, 0.5f));
        Image broken(64, 64, 3, 0.5f);
        broken.values[5] = std::numeric_limits<float>::quiet_NaN();
        writeExr(nan, broken);
        writeExr(black, Image(16, 16, 3, 0.0f));
    }

    void expect(const std::vector<Case>& cases, const std::vector<std::string>& environment = {}) {
        for (const Case& c : cases) {
            std::string line;
            for (const auto& a : c.arguments)
                line += a + " ";
            const auto result = runProgram(c.arguments, environment);
            EXPECT_EQ(result.code, c.code) << line << "\n" << result.err;
            EXPECT_NE(result.err.find(c.says), std::string::npos) << line << "\n" << result.err;
            EXPECT_NE(result.err.find("  remedy: "), std::string::npos) << line << "\n" << result.err;
            EXPECT_EQ(result.out, "") << line; // with --json, too
            EXPECT_FALSE(fs::exists(out)) << line;
        }
    }

    const test::TemporaryFolder folder;
    const std::string out = folder / "out.exr", run = folder / "run";
    const std::string good = folder / "good.exr", large = folder / "large.exr", nan = folder / "nan.exr", black = folder / "black.exr";
    const std::string param = "painting.baseColor";
};

TEST_F(BadInput, Files) {
    fs::create_directory(folder / "scene");
    const std::string gltf = folder / "scene/scene.gltf", cut = folder / "cut.exr", nothing = folder / "nothing.gltf";
    fs::copy_file(kBox, gltf);
    fs::copy_file(CMPG_SOURCE_DIR "/scenes/box/painting.png", folder / "scene/painting.png");
    truncate(CMPG_SOURCE_DIR "/scenes/box/scene.bin", folder / "scene/scene.bin", 0.5);
    truncate(good, cut, 0.7);
    test::writeText(nothing, "");
    test::writeText(folder / "scene.glb", "glTF\x02");
    test::writeText(folder / "picture.png", "\x89PNG\r\n\x1a\n and no more");
    const std::vector<std::string> optimize = {"optimize", kBox, "--param", param, "-o", run};
    const auto with = [](std::vector<std::string> arguments, const std::vector<std::string>& more) {
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    expect({
        {{"render", gltf, "-o", out, "--json"}, 3, "truncated"},
        {{"render", nothing, "-o", out}, 3, "nothing.gltf"},
        {{"render", folder / "scene.glb", "-o", out}, 3, "scene.glb"},
        {{"render", folder.path(), "-o", out}, 3, "not a regular file"},
        {{"render", good, "-o", out}, 3, "good.exr"},
        {{"view", cut, "-o", folder / "a.png"}, 3, "cut.exr"},
        {{"view", folder / "picture.png", "-o", folder / "a.png"}, 3, "picture.png"},
        {{"render", kBox, "-o", out, "--set", param + "=" + folder / "missing.exr"}, 3, "missing.exr"},
        {{"render", kBox, "-o", out, "--set", param + "=" + nan}, 3, "finite"},
        {{"render", kBox, "-o", out, "--set", param + "=" + good}, 3, "64x64"},
        {{"gradient", kBox, "-o", out, "--param", param, "--direction", good}, 3, "64x64"},
        {{"gradient", kBox, "-o", out, "--param", param, "--adjoint", cut}, 3, "cut.exr"},
        {{"gradient", kBox, "-o", out, "--param", param, "--target", cut}, 3, "cut.exr"},
        {with(optimize, {"--target", folder / "missing.png"}), 3, "missing.png"},
        {with(optimize, {"--target", cut}), 3, "cut.exr"},
        {with(optimize, {"--target", good, "--mask", large}), 3, "20 x 12"},
        {with(optimize, {"--target", good, "--mask", black}), 3, "no pixel"},
        {with(optimize, {"--target", "corner=" + good, "--target", "front=" + good, "--mask", "front=" + black}), 3, "no pixel"},
        {with(optimize, {"--target", good, "--width", "20"}), 3, "16x16"},
    });
    EXPECT_FALSE(fs::exists(run)); // input is looked at before anything is written
}

TEST_F(BadInput, Usage) {
    test::writeText(folder / "run.json", R"({"command": "render", "spp": "many"})");
    test::writeText(folder / "list.json", "[]");
    expect({
        {{"render", kBox, "-o", out, "--width", "0"}, 2, "--width"},
        {{"render", kBox, "-o", out, "--width", "4000000000"}, 2, "--width"},
        {{"render", kBox, "-o", out, "--width", "32768", "--height", "32768"}, 2, "32768x32768"},
        {{"render", kBox, "-o", out, "--spp", "-1"}, 2, "--spp"},
        {{"render", kBox, "-o", out, "--spp", "99999999999999999999"}, 2, "--spp"},
        {{"render", kBox, "-o", out, "--max-depth", "0"}, 2, "--max-depth"},
        {{"render", kBox, "-o", out, "--filter", "mitchell"}, 2, "there is no filter 'mitchell'"},
        {{"render", kBox, "-o", out, "--filter", "tent:99"}, 2, "from 0.01 to 32 pixels"},
        {{"render", kBox, "-o", out, "--memory", "1"}, 2, "--memory"},
        {{"render", kBox, "-o", out, "--memory", "16", "--max-depth", "1000"}, 2, "--memory"},
        {{"render", kBox, "-o", out, "--set", param + "=0.1,0.2"}, 2, "channel"},
        {{"render", kBox, "-o", out, "--set", param + "=-1"}, 2, "range"},
        {{"render", kBox, "-o", out, "--set", param + "=nan"}, 2, "range"},
        {{"render", kBox, "-o", out, "--set", param + "="}, 2, "--set"},
        {{"render", kBox, "-o", out, "--texture", "painting.normal=4x4"}, 2, "normal map"},
        {{"render", kBox, "-o", out, "--texture", param + "=4x4", "--set", param + "=" + good}, 3, "4x4"},
        {{"gradient", kBox, "-o", out}, 2, "--param"},
        {{"gradient", kBox, "-o", out, "--param", "white.color"}, 2, "white.color"},
        {{"gradient", kBox, "-o", out, "--param", param, "--adjoint", good, "--target", good}, 2, "--adjoint"},
        {{"gradient", kBox, "-o", out, "--param", param, "--adjoint", good, "--direction", "self"}, 2, "--direction"},
        {{"gradient", kBox, "-o", out, "--param", param, "--target", "nobody=" + good}, 2, "nobody"},
        {{"optimize", kBox, "-o", run, "--param", param}, 2, "--target"},
        {{"optimize", kBox, "-o", run, "--param", param, "--target", good, "--mask", "corner=" + good}, 2, "no target of the camera corner"},
        {{"gradient", kBox, "-o", out, "--param", param, "--target", good, "--mask", "corner=" + good}, 2, "no target of the camera corner"},
        {{"compare", kBox, "-o", run, "--param", param, "--target", good, "--mask", "corner=" + good}, 2, "no target of the camera corner"},
        {{"optimize", kBox, "-o", run, "--param", param, "--target", good, "--target", "front=" + good}, 2, "front, corner"},
        {{"optimize", kBox, "-o", run, "--param", param, "--target", good, "--steps", "0"}, 2, "--steps"},
        {{"optimize", kBox, "-o", run, "--param", param, "--target", good, "--loss", "l3"}, 2, "l3"},
        {{"optimize", kBox, "-o", run, "--param", param, "--target", good, "--rate", "colour=1"}, 2, "colour"},
        {{"--config", folder / "missing.json"}, 2, "missing.json"},
        {{"--config", folder / "run.json"}, 2, "spp"},
        {{"--config", folder / "list.json"}, 2, "object"},
        {{"--config", good}, 2, "good.exr"},
    });
}

TEST_F(BadInput, Devices) {
    const std::vector<std::string> none = {"VK_ICD_FILENAMES=/nonexistent/icd.json", "VK_DRIVER_FILES=/nonexistent/icd.json"};
    expect(
        {
            {{"render", kBox, "-o", out, "--json"}, 4, "no Vulkan"},
            {{"gradient", kBox, "-o", out, "--param", param}, 4, "no Vulkan"},
            {{"optimize", kBox, "-o", run, "--param", param, "--target", good}, 4, "no Vulkan"},
        },
        none);
    expect({{{"render", kBox, "-o", out, "--device", "no such device"}, 4, "no such device"}});
}

TEST_F(BadInput, Outputs) {
    test::writeText(folder / "file", "");
    expect({
        {{"render", kBox, "-o", folder / "file/out.exr"}, 6, "file"},
        {{"render", kBox, "-o", "/proc/out.exr"}, 6, "/proc"},
        {{"gradient", kBox, "-o", "/proc/out.exr", "--param", param, "--adjoint", good}, 6, "/proc"},
        {{"gradient", kBox, "-o", folder / "file", "--param", "*.baseColor", "--adjoint", good}, 6, "folder"},
        {{"gradient", kBox, "-o", out, "--param", param, "--adjoint", good, "--train", "1", "--save-guide", folder.path()}, 6, "it is a folder"},
        {{"gradient", kBox, "-o", out, "--param", param, "--train", "1", "--save-guide", "/proc/a.guide"}, 6, "/proc/a.guide"},
        {{"render", kBox, "-o", out, "--train", "1", "--save-guide", folder / "file/a.guide"}, 6, "cannot make the folder"},
        {{"optimize", kBox, "-o", folder / "file", "--param", param, "--target", good}, 6, "folder"},
        {{"optimize", kBox, "-o", "/proc/run", "--param", param, "--target", good}, 6, "/proc/run"},
    });
    EXPECT_EQ(test::readText(folder / "file"), "");
}

// A lamp near the end of what a float holds: sums overflow. The result is kept, the exit code says what it is worth.
TEST_F(BadInput, OverflowingLight) {
    const auto result = runProgram({"render", kFurnace, "-o", out, "--set", "wall.emission=3e38", "--width", "16", "--height", "16", "--spp", "4"});
    EXPECT_EQ(result.code, 5) << result.err;
    EXPECT_NE(result.err.find("  remedy: "), std::string::npos) << result.err;
    EXPECT_TRUE(fs::exists(out));
}

} // namespace
} // namespace cmpg
