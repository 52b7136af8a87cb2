// Devices that compute wrong results: the program says so and ends, and does not bring a driver to it.
#include "command_line.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

using test::runProgram, test::TemporaryFolder;
using Environment = std::vector<std::string>;

const std::string kScene = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";

TEST(WrongDevice, IsRefused) {
    const TemporaryFolder folder;
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"inspect", kScene}, {"render", kScene, "-o", folder / "image.exr"}}) {
        const auto refused = runProgram(arguments, {"CMPG_FAULT=wrong"});
        EXPECT_EQ(refused.code, 4) << refused.err;
        for (const char* part : {"computes wrong results", "its driver, ", "another version of the driver", "--device", "VK_ICD_FILENAMES"})
            EXPECT_NE(refused.err.find(part), std::string::npos) << part << " in\n" << refused.err;
    }
    EXPECT_EQ(runProgram({"--list-devices"}, {"CMPG_FAULT=wrong"}).code, 0); // opens none
    EXPECT_EQ(runProgram({"inspect", kScene}, {"CMPG_FAULT=wrong:1"}).code, 2);
}

// Mesa 25 mixes code for vectors of several widths in its cache on disk. Here the cache is made sure to be used.
class VectorWidth : public testing::Test {
  protected:
    void SetUp() override {
        if (!*CMPG_SECOND_DRIVER)
            GTEST_SKIP() << "Mesa 25 is not installed: scripts/backports-driver fetches it";
        if (runProgram({"--version"}, with({})).out.find("Mesa 25.0") == std::string::npos)
            GTEST_SKIP() << CMPG_SECOND_DRIVER << " is no Mesa 25.0";
    }
    Environment with(Environment more) const {
        more.insert(more.end(),
                    {"VK_ICD_FILENAMES=" CMPG_SECOND_DRIVER, "VK_DRIVER_FILES=" CMPG_SECOND_DRIVER, "MESA_SHADER_CACHE_DIR=" + folder_.path()});
        return more;
    }
    TemporaryFolder folder_;
};

TEST_F(VectorWidth, MixedInTheCacheIsRefused) {
    const auto inspect = [&](const std::string& width) {
        return runProgram({"inspect", kScene}, with({"LP_NATIVE_VECTOR_WIDTH=" + width, "MESA_SHADER_CACHE_DISABLE=false"}));
    };
    const auto first = inspect("256");
    EXPECT_EQ(first.code, 0) << first.err;
    const auto second = inspect("512");
    EXPECT_EQ(second.code, 4) << second.err;
    for (const char* part : {"Mesa 25.0", "LP_NATIVE_VECTOR_WIDTH", "MESA_SHADER_CACHE_DISABLE"})
        EXPECT_NE(second.err.find(part), std::string::npos) << part << " in\n" << second.err;
}

TEST_F(VectorWidth, OfTheUsersChoiceStaysOutOfTheCache) {
    const auto image = [&](const std::string& name, Environment environment) {
        const auto rendered =
            runProgram({"render", kScene, "--width", "8", "--height", "8", "--spp", "1", "-o", folder_ / name}, with(std::move(environment)));
        EXPECT_EQ(rendered.code, 0) << rendered.err;
        return test::readText(folder_ / name);
    };
    const std::string plain = image("plain.exr", {}); // fills the cache
    EXPECT_EQ(image("wide.exr", {"LP_NATIVE_VECTOR_WIDTH=512"}), plain);
    EXPECT_EQ(image("again.exr", {}), plain);
}

} // namespace
} // namespace cmpg
