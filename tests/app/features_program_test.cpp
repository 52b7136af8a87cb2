// --all-features and inspect as a user runs them: the same files, and figures of what leaving things out saves.
#include "command_line.h"

#include <cmpg/renderer.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";

nlohmann::json run(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--headless", "--json", "--width", "16", "--height", "16", "--spp", "2", "--max-depth", "4"});
    const auto result = runProgram(arguments);
    EXPECT_EQ(result.code, 0) << arguments[0] << "\n" << result.err;
    return result.code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json::object();
}

TEST(ProgramFeatures, AllFeaturesGiveTheSameFiles) {
    const test::TemporaryFolder folder;
    const auto own = run({"render", kBox, "-o", folder / "own.exr"});
    const auto all = run({"render", kBox, "-o", folder / "all.exr", "--all-features"});
    if (own.at("device").get<std::string>().find("llvmpipe") == std::string::npos)
        GTEST_SKIP() << "compilers of other devices may contract differently";
    EXPECT_TRUE(readText(folder / "own.exr") == readText(folder / "all.exr"));
    EXPECT_LT(own.at("memory").at("device_peak_bytes"), all.at("memory").at("device_peak_bytes"));
    EXPECT_LT(own.at("rays"), all.at("rays")); // without an environment last rays look for emitters alone
}

TEST(ProgramFeatures, InspectComparesWithEverything) {
    const auto json = run({"inspect", kBox, "--param", "painting.baseColor"});
    EXPECT_EQ(json.at("features").at("textures"), "baseColor");
    EXPECT_EQ(json.at("features").at("specular lobe"), "off");
    EXPECT_EQ(json.at("features").at("guided directions"), "off");
    EXPECT_TRUE(json.at("kernels").empty()); // none ran
    bool split = false;
    std::uint64_t sum = 0;
    for (const auto& k : json.at("kernel_sizes")) {
        sum += k.at("scene").get<std::uint64_t>();
        if (k.at("kernel") != "sort_vertices") { // with every feature on there are no classes of surfaces to sort by
            EXPECT_LE(k.at("scene"), k.at("all_features")) << k;
        }
        EXPECT_LE(k.at("all_features"), k.at("module")) << k;
        split |= k.at("kernel") == "split_paths" && k.at("scene") == 0;
        if (k.at("kernel") == "shade_vertex") {
            // 0.58 of it for images, of two classes of surfaces, and 0.73 for gradients, of a third.
            EXPECT_LT(k.at("scene").get<double>(), 0.8 * k.at("all_features").get<double>()) << k;
        }
    }
    EXPECT_TRUE(split);
    v1::Renderer renderer(v1::Device(), v1::Scene::load(kBox), {.paths = {.maxDepth = 4}, .parameters = {"painting.baseColor"}});
    std::uint64_t all = 0; // classes of surfaces have kernels of their own
    for (const v1::Footprint::Kernel& k : renderer.footprint({v1::PassKind::Render, v1::PassKind::Forward, v1::PassKind::Backward}).kernels)
        all += k.bytes;
    EXPECT_EQ(sum, all);
    EXPECT_LT(json.at("buffers").at("tape"), json.at("buffers_all_features").at("tape"));
    EXPECT_FALSE(json.at("buffers").contains("guide quadtrees"));
    EXPECT_TRUE(json.at("buffers_all_features").contains("guide quadtrees"));
}

} // namespace
} // namespace cmpg
