// Results do not depend on the driver's threads, the kernels' variant or the memory budget: files are equal byte for byte.
#include "command_line.h"
#include "scene/image.h"

#include <functional>
#include <gtest/gtest.h>
#include <map>

namespace cmpg {
namespace {

using test::runProgram;

const std::string kMaterials = CMPG_SOURCE_DIR "/scenes/materials/scene.gltf", kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";

struct Variation {
    const char* name;
    std::vector<std::string> environment, arguments;
    bool full = false;         // for the long tests: others vary the same
    bool otherKernels = false; // which take long to compile; of guided passes GuidedDeterminism.SameBitsOnPortableKernels has them
};
const Variation kVariations[] = {
    {"one thread", {"LP_NUM_THREADS=1"}, {}}, // of lavapipe; other drivers ignore the variable, and are then tested for repeating themselves
    {"two threads", {"LP_NUM_THREADS=2"}, {}, true},
    {"eight threads", {"LP_NUM_THREADS=8"}, {}},
    {"portable kernels", {"CMPG_PORTABLE=1"}, {}, false, true}, // storage buffers instead of texel buffers, pairs of 32-bit additions for 64-bit ones
    {"uniform texel buffers", {"CMPG_TEXELS=uniform"}, {}, false, true}, // as GPUs read; CPUs have storage texel buffers
    {"a small budget", {}, {"--memory", "16"}}, // hence small batches
    {"a middling budget", {}, {"--memory", "48"}, true},
    {"nothing", {}, {}, true}, // what does not repeat itself differs above as well
};

class Independence : public testing::Test {
  protected:
    using Files = std::map<std::string, std::string>; // contents by name
    using Run = std::function<void(std::vector<std::string> arguments)>;

    // `commands` write `files` into folder_ with a run that adds small images and the variation.
    void expectSameFiles(const std::function<bool(const Variation&)>& chosen, const std::vector<std::string>& files, const std::function<void(const Run&)>& commands) {
        writeExr(folder_ / "image.exr", Image(40, 32, 3, 0.5f));
        const auto results = [&](const Variation& variation) {
            commands([&](std::vector<std::string> arguments) {
                arguments.insert(arguments.end(), {"--width", "40", "--height", "32", "--quiet", "--headless"});
                arguments.insert(arguments.end(), variation.arguments.begin(), variation.arguments.end());
                const auto result = runProgram(arguments, variation.environment);
                EXPECT_EQ(result.code, 0) << variation.name << ": " << result.err;
            });
            Files contents;
            for (const std::string& file : files) {
                contents[file] = test::readText(folder_ / file);
                EXPECT_FALSE(contents[file].empty()) << file;
                std::filesystem::remove(folder_ / file); // the next run has to write its own
            }
            return contents;
        };
        const Files usual = results({"as usual", {}, {}});
        for (const Variation& variation : kVariations) {
            if (!chosen(variation))
                continue;
            Files varied = results(variation);
            for (const auto& [file, content] : usual)
                EXPECT_TRUE(varied[file] == content) << file << " differs with " << variation.name; // an equality would print the files
        }
    }

    void plainPasses(bool full) {
        expectSameFiles([full](const Variation& v) { return v.full == full; }, {"render.exr", "forward.exr", "reverse.exr"}, [&](const Run& run) {
            run({"render", kMaterials, "--spp", "8", "-o", folder_ / "render.exr"});
            run({"gradient", kMaterials, "--param", "varied.*", "--spp", "8", "-o", folder_ / "forward.exr"});
            run({"gradient", kMaterials, "--param", "varied.baseColor", "--adjoint", folder_ / "image.exr", "--spp", "8", "-o", folder_ / "reverse.exr"});
        });
    }

    // Learning, the automatic choice, the roulette, and what an optimisation makes of them.
    void guidedPasses(bool full) {
        const std::string recovered = "run/parameters/painting.baseColor.exr", last = "run/gradients/painting.baseColor.exr";
        expectSameFiles([full](const Variation& v) { return (v.full || v.otherKernels) == full; }, {"a.guide", "b.guide", "gradient.exr", recovered, last, "run/final.exr"}, [&](const Run& run) {
            run({"gradient", kBox, "--param", "painting.baseColor", "--adjoint", folder_ / "image.exr", "--spp-gradient", "8", "--train", "3",
                 "--save-guide", folder_ / "a.guide", "-o", folder_ / "gradient.exr"});
            run({"optimize", kBox, "--param", "painting.baseColor", "--target", folder_ / "image.exr", "--spp", "4", "--spp-gradient", "4", "--steps",
                 "12", "--save-guide", folder_ / "b.guide", "-o", folder_ / "run"});
        });
    }

  private:
    const test::TemporaryFolder folder_;
};

TEST_F(Independence, PlainPasses) { plainPasses(false); }
TEST_F(Independence, GuidedPasses) { guidedPasses(false); }
TEST_F(Independence, FullPlainPasses) { plainPasses(true); }
TEST_F(Independence, FullGuidedPasses) { guidedPasses(true); }

} // namespace
} // namespace cmpg
