// What the rendering commands tell about their guide.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

using test::runProgram;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";

TEST(ProgramGuide, TellsWhatItsMemoryCost) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(96, 96, 3, 1.0f));
    const auto learn = [&](const std::string& mebibytes) {
        const auto result = runProgram({"gradient", kBox, "--param", "painting.baseColor", "--adjoint", folder / "adjoint.exr", "--spp-gradient",
                                        "4", "--train", "2", "--train-spp", "32", "--guide-memory", mebibytes, "-o", folder / "a.exr", "--json"});
        EXPECT_EQ(result.code, 0) << result.err;
        std::size_t warnings = 0;
        for (std::size_t at = 0; (at = result.err.find("--guide-memory", at)) != std::string::npos; ++at)
            ++warnings;
        return std::pair(nlohmann::json::parse(result.out).at("memory").at("refused_splits").get<std::uint64_t>(), warnings);
    };
    const auto [refused, warnings] = learn("1"); // some 3000 nodes
    EXPECT_GT(refused, 0u);
    EXPECT_EQ(warnings, 1u);
    EXPECT_EQ(learn("64"), std::pair(std::uint64_t(0), std::size_t(0)));
}

TEST(ProgramGuide, DerivativesHaveLayers) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> common = {"gradient", kBox,  "--param", "white.baseColor", "--width", "16",         "--height", "16",
                                             "--spp",    "16",  "--train", "2",               "--sampling", "conditional", "--json",   "--max-depth", "4"};
    const auto run = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = common;
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = runProgram(arguments);
        EXPECT_EQ(result.code, 0) << result.err;
        return nlohmann::json::parse(result.out);
    };
    run({"-o", folder / "plain.exr"});
    const auto json = run({"-o", folder / "a.exr", "--layers", folder / "l.exr"});
    EXPECT_EQ(json.at("outputs").at("layers"), folder / "l.exr");
    EXPECT_TRUE(test::readText(folder / "plain.exr") == test::readText(folder / "a.exr")) << "layers changed the result";
    for (const int vertex : {1, 2, 3}) {
        const Image share = readImage(folder / "l.exr", {.layer = "light_share" + std::to_string(vertex)}).image;
        const double told = json.at("guided_by_depth").at(std::size_t(vertex - 1)).at("light_share");
        double mean = 0, count = 0;
        for (const float s : share.values)
            if (s >= 0) {
                EXPECT_LE(s, 1);
                mean += double(s);
                ++count;
            }
        EXPECT_GT(count, 0.9 * 256) << vertex;
        // Pixels count alike here, directions in the sum by depth.
        EXPECT_NEAR(mean / count, told, 0.05) << vertex;
    }
    EXPECT_NE(runProgram({"view", folder / "l.exr", "--layer", "light_share4", "-o", folder / "l.png"}).code, 0); // the last segment draws nothing
}

} // namespace
} // namespace cmpg
