// Results do not depend on how many threads the driver has, nor on which variant of the kernels runs: files are equal byte for byte.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

const std::string kMaterials = CMPG_SOURCE_DIR "/scenes/materials/scene.gltf";

struct Files {
    std::string image, forward, reverse;
};

// An image, a forward and a reverse derivative under these settings of the environment.
Files results(const std::vector<std::string>& environment) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(40, 32, 3, 0.5f));
    const auto run = [&](const std::string& output, std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"-o", folder / output, "--width", "40", "--height", "32", "--spp", "8", "--quiet", "--headless"});
        const auto result = runProgram(arguments, environment);
        EXPECT_EQ(result.code, 0) << result.err;
        return readText(folder / output);
    };
    Files files;
    files.image = run("image.exr", {"render", kMaterials});
    files.forward = run("forward.exr", {"gradient", kMaterials, "--param", "varied.*"});
    files.reverse = run("reverse.exr", {"gradient", kMaterials, "--param", "varied.baseColor", "--adjoint", folder / "adjoint.exr"});
    EXPECT_FALSE(files.image.empty() || files.forward.empty() || files.reverse.empty());
    return files;
}

// An expectation of equality would print the files.
void expectSame(const Files& a, const Files& b) {
    EXPECT_TRUE(a.image == b.image) << "images differ";
    EXPECT_TRUE(a.forward == b.forward) << "forward derivatives differ";
    EXPECT_TRUE(a.reverse == b.reverse) << "reverse derivatives differ";
}

class Independence : public testing::Test {
  protected:
    static const Files& usual() {
        static const Files files = results({});
        return files;
    }
};

// lavapipe's threads; other drivers ignore the variable, and are then tested for repeating themselves.
TEST_F(Independence, OneThread) { expectSame(usual(), results({"LP_NUM_THREADS=1"})); }
TEST_F(Independence, TwoThreads) { expectSame(usual(), results({"LP_NUM_THREADS=2"})); }

// Storage buffers instead of texel buffers, pairs of 32-bit additions instead of 64-bit ones.
TEST_F(Independence, PortableKernels) { expectSame(usual(), results({"CMPG_PORTABLE=1"})); }

} // namespace
} // namespace cmpg
