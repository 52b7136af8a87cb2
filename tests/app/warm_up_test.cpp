// Kernels compiled on several devices at once: the same results, and a helper that fails is no more than a warning.
#include "command_line.h"
#include "scene/image.h"
#include "vk/device.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

class WarmUp : public testing::Test {
  protected:
    void SetUp() override {
        const std::vector<DeviceInfo> devices = Device::list();
        if (std::ranges::none_of(devices, [](const DeviceInfo& device) { return device.name.starts_with("llvmpipe"); }))
            GTEST_SKIP() << "other drivers compile before the first dispatch";
        writeExr(folder_ / "image.exr", Image(24, 24, 3, 0.5f));
    }

    // With a cache that has nothing yet.
    test::ProgramResult run(const std::string& name, std::vector<std::string> environment) {
        std::filesystem::create_directory(folder_ / (name + "-cache"));
        environment.insert(environment.end(), {"MESA_SHADER_CACHE_DISABLE=false", "MESA_SHADER_CACHE_DIR=" + folder_ / (name + "-cache")});
        return test::runProgram({"gradient", CMPG_SOURCE_DIR "/scenes/box/scene.gltf", "--device", "llvmpipe", "--param", "painting.baseColor",
                                 "--adjoint", folder_ / "image.exr", "--width", "24", "--height", "24", "--spp", "2", "--quiet", "--headless", "-o",
                                 folder_ / (name + ".exr")},
                                environment);
    }
    std::string result(const std::string& name) const { return test::readText(folder_ / (name + ".exr")); }

    const test::TemporaryFolder folder_;
};

TEST_F(WarmUp, HelpersChangeNoResult) {
    const auto alone = run("alone", {"CMPG_COMPILERS=1"}), helped = run("helped", {"CMPG_COMPILERS=3"});
    EXPECT_EQ(alone.code, 0) << alone.err;
    EXPECT_EQ(helped.code, 0) << helped.err;
    EXPECT_EQ(helped.err, alone.err);
    EXPECT_FALSE(result("alone").empty());
    EXPECT_TRUE(result("helped") == result("alone"));
}

// That the warning comes also shows that there was a helper.
TEST_F(WarmUp, AHelperThatFailsIsAWarning) {
    const auto alone = run("alone", {"CMPG_COMPILERS=1"}), failed = run("failed", {"CMPG_COMPILERS=2", "CMPG_FAULT=helper:0"});
    EXPECT_EQ(failed.code, 0) << failed.err;
    EXPECT_NE(failed.err.find("compiled one after the other"), std::string::npos) << failed.err;
    EXPECT_NE(failed.err.find("the device was lost"), std::string::npos) << failed.err;
    EXPECT_TRUE(result("failed") == result("alone"));
    const auto unasked = run("unasked", {"CMPG_COMPILERS=1", "CMPG_FAULT=helper:0"});
    EXPECT_EQ(unasked.err, alone.err);
}

TEST_F(WarmUp, WithoutACacheNobodyHelps) {
    const auto off = run("off", {"CMPG_COMPILERS=2", "CMPG_FAULT=helper:0", "MESA_GLSL_CACHE_DISABLE=true"});
    EXPECT_EQ(off.code, 0) << off.err;
    EXPECT_EQ(off.err.find("compiled one after the other"), std::string::npos) << off.err;
}

} // namespace
} // namespace cmpg
