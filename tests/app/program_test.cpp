// The program as a user runs it: exit codes, what goes to stdout and to stderr. Nothing here renders; see CMPG_BINARY.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

using test::runProgram;

// A camera and nothing to see: enough for everything that comes before rendering.
constexpr const char* kEmptyScene =
    R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "eye", "camera": 0}],
    "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 2.0, "znear": 0.1}}]})";

const std::vector<std::string> kNoDevice = {"VK_ICD_FILENAMES=/nonexistent/icd.json", "VK_DRIVER_FILES=/nonexistent/icd.json"};

struct Case {
    std::vector<std::string> arguments;
    int code;
    std::string says; // part of the message on stderr
};

TEST(Program, ExitCodes) {
    const test::TemporaryFolder folder;
    const std::string scene = folder / "scene.gltf", out = folder / "a.exr", image = folder / "image.exr";
    test::writeText(scene, kEmptyScene);
    test::writeText(folder / "cut.gltf", std::string(kEmptyScene).substr(0, 60));
    test::writeText(folder / "cut.exr", "v/1\x01");
    writeExr(image, Image(4, 4, 3, 0.5f));
    const std::vector<Case> cases = {
        {{}, 2, "no command"},
        {{"--frobnicate"}, 2, "frobnicate"},
        {{"frobnicate"}, 2, "neither a command nor a scene"},
        {{std::string(300, 'x')}, 2, "neither a command nor a scene"}, // too long for a file to have it
        {{"--headless", scene}, 2, "--headless render"},
        {{"render"}, 2, "scene"},
        {{"render", scene}, 2, "-o"},
        {{"render", scene, "-o", folder / "a.txt"}, 2, ".exr"},
        {{"render", scene, "-o", out, "--set", "nothing.baseColor=1"}, 2, "nothing.baseColor"},
        {{"render", scene, "-o", out, "--camera", "nobody"}, 2, "nobody"},
        {{"gradient", scene, "--param", "nothing.*", "-o", out}, 2, "nothing.*"},
        {{"render", folder / "missing.gltf", "-o", out}, 3, "missing.gltf"},
        {{"render", folder / "cut.gltf", "-o", out}, 3, "cut.gltf"},
        {{"inspect", folder / "missing.gltf"}, 3, "missing.gltf"},
        {{"view", folder / "missing.exr", "-o", folder / "a.png"}, 3, "missing.exr"},
        {{"view", folder / "cut.exr", "-o", folder / "a.png"}, 3, "cut.exr"},
        {{"render", scene, "-o", "/nonexistent/a.exr"}, 6, "/nonexistent"},
        {{"render", scene, "-o", out, "--layers", "/nonexistent/l.exr"}, 6, "/nonexistent"},
        {{"view", image, "-o", "/nonexistent/a.png"}, 6, "/nonexistent"},
        {{"view", image, "-o", folder.path()}, 6, "folder"},
    };
    for (const Case& c : cases) {
        std::string line;
        for (const auto& a : c.arguments)
            line += a + " ";
        const auto result = runProgram(c.arguments);
        EXPECT_EQ(result.code, c.code) << line << "\n" << result.err;
        EXPECT_NE(result.err.find(c.says), std::string::npos) << line << "\n" << result.err;
        EXPECT_EQ(result.out, "") << line; // errors belong on stderr
        EXPECT_FALSE(std::filesystem::exists(out)) << line;
    }
}

TEST(Program, RunsWithoutADevice) {
    const test::TemporaryFolder folder;
    const std::string scene = folder / "scene.gltf", image = folder / "image.exr";
    test::writeText(scene, kEmptyScene);
    writeExr(image, Image(4, 4, 3, 0.5f));
    EXPECT_EQ(runProgram({"--help"}, kNoDevice).code, 0);
    const auto version = runProgram({"--version"}, kNoDevice);
    EXPECT_EQ(version.code, 0) << version.err;
    EXPECT_NE(version.out.find("cmpg-vk 0."), std::string::npos) << version.out;
    EXPECT_EQ(runProgram({"view", image, "-o", folder / "a.png"}, kNoDevice).code, 0);
    const auto render = runProgram({"render", scene, "-o", folder / "a.exr"}, kNoDevice);
    EXPECT_EQ(render.code, 4) << render.err;
    EXPECT_NE(render.err.find("remedy"), std::string::npos) << render.err;
    const auto inspect = runProgram({"inspect", scene}, kNoDevice);
    EXPECT_EQ(inspect.code, 4);
    EXPECT_NE(inspect.out.find("eye"), std::string::npos) << inspect.out; // what needs no device is printed all the same
}

TEST(Program, InspectAlignsNamesOfManyBytes) {
    const test::TemporaryFolder folder;
    const std::string scene = folder / "scene.gltf";
    std::string text = kEmptyScene;
    text.insert(text.rfind('}'), R"(, "materials": [{"name": "Größe"}, {"name": "plain"}])");
    test::writeText(scene, text);
    const auto inspect = runProgram({"inspect", scene}, kNoDevice);
    for (const char* line : {"  Größe.specular   1x1", "  plain.specular   1x1"})
        EXPECT_NE(inspect.out.find(line), std::string::npos) << line << "\n" << inspect.out;
}

// A window cannot be opened without a display, nor without its module.
TEST(Program, WithoutAWindowSaysHowToWork) {
    const test::TemporaryFolder folder;
    const std::string scene = folder / "scene.gltf", alone = folder / "cmpg-vk";
    test::writeText(scene, kEmptyScene);
    const auto noDisplay = runProgram({scene}, {"DISPLAY=", "WAYLAND_DISPLAY="});
    EXPECT_EQ(noDisplay.code, 4) << noDisplay.err;
    EXPECT_NE(noDisplay.err.find("--headless"), std::string::npos) << noDisplay.err;

    std::filesystem::copy_file(CMPG_BINARY, alone);
    const std::string command = alone + " " + scene + " 2>" + folder / "err";
    EXPECT_EQ(std::system(command.c_str()) >> 8, 4);
    const std::string message = test::readText(folder / "err");
    EXPECT_NE(message.find("libcmpg-viewer.so"), std::string::npos) << message;
    EXPECT_NE(message.find("--headless"), std::string::npos) << message;
}

TEST(Program, PrintsOneJsonObject) {
    const test::TemporaryFolder folder;
    writeExr(folder / "a.exr", Image(4, 3, 3, -0.5f));
    for (const bool before : {false, true}) {
        std::vector<std::string> arguments = {"view", folder / "a.exr", "-o", folder / "a.png", "--signed"};
        arguments.insert(before ? arguments.begin() : arguments.end(), "--json");
        const auto result = runProgram(arguments);
        ASSERT_EQ(result.code, 0) << result.err;
        const auto json = nlohmann::json::parse(result.out); // throws on anything beside the object
        EXPECT_EQ(json.at("command"), "view");
        EXPECT_EQ(json.at("width"), 4);
        EXPECT_EQ(json.at("height"), 3);
        EXPECT_EQ(json.at("outputs").at("image"), folder / "a.png");
        EXPECT_NE(result.err.find("scale"), std::string::npos);
    }
    EXPECT_EQ(nlohmann::json::parse(runProgram({"--list-devices", "--json"}).out).at("command"), "list-devices");
}

TEST(Program, SaysWhenStandardOutputTakesNoMore) {
    const test::TemporaryFolder folder;
    // A device that refuses all writing stands in for a full disk.
    if (!std::filesystem::exists("/dev/full"))
        GTEST_SKIP();
    const std::string command = std::string(CMPG_BINARY) + " --version >/dev/full 2>" + folder / "err";
    EXPECT_EQ(std::system(command.c_str()) >> 8, 6) << test::readText(folder / "err");
}

} // namespace
} // namespace cmpg
