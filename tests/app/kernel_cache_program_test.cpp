// The program with and without its cache of kernels.
#include "command_line.h"

#include <fstream>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

TEST(KernelCacheProgram, ResultsDoNotDependOnIt) {
    const test::TemporaryFolder folder;
    const auto arguments = [&](const std::string& name) {
        return std::vector<std::string>{"render", CMPG_SOURCE_DIR "/scenes/box/scene.gltf", "--width", "16", "--height", "16", "--spp", "2",
                                        "--quiet", "--headless", "-o", folder / (name + ".exr")};
    };
    const auto run = [&](const std::string& name, const std::string& cache) {
        const auto result = test::runProgram(arguments(name), {"CMPG_CACHE=" + cache});
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_EQ(result.err, "");
        return test::readText(folder / (name + ".exr"));
    };
    const std::string none = run("none", "0"), cache = folder / "cache";
    EXPECT_FALSE(none.empty());
    { // two that begin at once, with nothing there
        const std::vector<std::string> environment{"CMPG_CACHE=" + cache};
        test::RunningProgram first(arguments("first"), folder / "a", environment), second(arguments("second"), folder / "b", environment);
        EXPECT_EQ(first.wait().code, 0);
        EXPECT_EQ(second.wait().code, 0);
    }
    EXPECT_TRUE(test::readText(folder / "first.exr") == none);
    EXPECT_TRUE(test::readText(folder / "second.exr") == none);
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(cache))
        files += entry.path().extension() == ".spirv";
    EXPECT_GT(files, 5u);
    EXPECT_TRUE(run("warm", cache) == none);
    for (const auto& entry : fs::directory_iterator(cache)) { // half of each
        const std::string text = test::readText(entry.path().string());
        test::writeText(entry.path().string(), text.substr(0, text.size() / 2));
    }
    EXPECT_TRUE(run("damaged", cache) == none);
    EXPECT_TRUE(run("nowhere", folder / "none.exr/below") == none);
}

} // namespace
} // namespace cmpg
