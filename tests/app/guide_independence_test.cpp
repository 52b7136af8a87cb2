// Learning, the automatic choice and the roulette do not depend on the driver's threads, the kernels' variant or the memory budget: what
// is learned, gradients and optimised textures are equal byte for byte.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";

struct Files {
    std::string guide, gradient, optimised;
};

Files results(const std::vector<std::string>& environment, const std::vector<std::string>& more = {}) {
    const test::TemporaryFolder folder;
    writeExr(folder / "image.exr", Image(40, 32, 3, 0.5f));
    const auto run = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--param", "painting.baseColor", "--width", "40", "--height", "32", "--quiet", "--headless"});
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = runProgram(arguments, environment);
        EXPECT_EQ(result.code, 0) << result.err;
    };
    run({"gradient", kBox, "--adjoint", folder / "image.exr", "--spp-gradient", "8", "--train", "3", "--save-guide", folder / "a.guide", "-o", folder / "gradient.exr"});
    run({"optimize", kBox, "--target", folder / "image.exr", "--spp", "4", "--spp-gradient", "4", "--steps", "12", "-o", folder / "run"});
    Files files{readText(folder / "a.guide"), readText(folder / "gradient.exr"), readText(folder / "run/parameters/painting.baseColor.exr")};
    EXPECT_FALSE(files.guide.empty() || files.gradient.empty() || files.optimised.empty());
    return files;
}

// An expectation of equality would print the files.
void expectSame(const Files& a, const Files& b) {
    EXPECT_TRUE(a.guide == b.guide) << "guides differ";
    EXPECT_TRUE(a.gradient == b.gradient) << "gradients differ";
    EXPECT_TRUE(a.optimised == b.optimised) << "optimised textures differ";
}

TEST(GuideIndependence, ThreadsVariantsAndBudgets) {
    const Files usual = results({});
    {
        SCOPED_TRACE("one thread");
        expectSame(usual, results({"LP_NUM_THREADS=1"}));
    }
    {
        SCOPED_TRACE("two threads");
        expectSame(usual, results({"LP_NUM_THREADS=2"}));
    }
    {
        SCOPED_TRACE("portable kernels");
        expectSame(usual, results({"CMPG_PORTABLE=1"}));
    }
    {
        SCOPED_TRACE("a small budget");
        expectSame(usual, results({}, {"--memory", "16"}));
    }
}

} // namespace
} // namespace cmpg
