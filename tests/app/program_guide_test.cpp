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
                                        "32", "--train", "2", "--guide-memory", mebibytes, "-o", folder / "a.exr", "--json"});
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

} // namespace
} // namespace cmpg
