// Long runs: memory stays what it was.
#include "command_line.h"
#include "scene/image.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <gtest/gtest.h>
#include <iostream>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

// Most of device and host memory in each tenth of a run, from its log.
void expectFlatMemory(std::uint32_t steps) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(24, 24, 3, 0.5f));
    const auto result = test::runProgram({"optimize", CMPG_SOURCE_DIR "/scenes/box/scene.gltf", "--param", "painting.baseColor", "--param", "light.emission",
                                          "--target", folder / "target.exr", "--spp", "1", "--spp-gradient", "1", "--steps", std::to_string(steps), "--max-depth",
                                          "4", "--memory", "32", "--checkpoint-every", std::to_string(steps / 20), "--quiet", "--headless", "-o", folder / "run"});
    ASSERT_EQ(result.code, 0) << result.err;
    constexpr std::size_t kParts = 10;
    std::array<double, kParts> device{}, host{};
    std::ifstream log(folder / "run/log.jsonl");
    for (std::string line; std::getline(log, line);) {
        const auto event = nlohmann::json::parse(line);
        if (event["event"] != "progress")
            continue;
        const std::size_t part = std::min<std::size_t>(kParts - 1, event["step"].get<std::size_t>() * kParts / steps);
        device[part] = std::max(device[part], event["device_bytes"].get<double>());
        host[part] = std::max(host[part], event["host_bytes"].get<double>());
    }
    for (std::size_t part = 0; part < kParts; ++part)
        std::cout << "part " << part << ": device " << device[part] / (1 << 20) << " MiB, host " << host[part] / (1 << 20) << " MiB\n";
    // The first parts try all sampling methods and grow the guide.
    const std::size_t first = 3, last = kParts - 1;
    ASSERT_GT(device[first], 0);
    ASSERT_GT(host[first], 0);
    EXPECT_NEAR(device[last], device[first], 0.01 * device[first]);
    EXPECT_NEAR(host[last], host[first], 0.01 * host[first]);
}

TEST(Bounded, MemoryIsFlat) { expectFlatMemory(200); }
TEST(Bounded, FullMemoryIsFlatOverTenThousandSteps) { expectFlatMemory(10000); }

// lavapipe compiles a kernel anew in every dispatch, and keeps what it compiled, where a branch by a value of a uniform buffer changes it much in the first one.
TEST(Bounded, GuidedPassesTakeNoMemoryEach) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(32, 24, 3, 0.5f));
    const auto peak = [&](const std::string& batches) {
        const auto result = test::runProgram({"gradient", CMPG_SOURCE_DIR "/scenes/bowl/scene.gltf", "--param", "table.baseColor", "--adjoint", folder / "adjoint.exr",
                                              "--width", "32", "--height", "24", "--train", "2", "--train-spp", "2", "--sampling", "conditional", "--spp-gradient",
                                              "64", "--batches", batches, "--memory", "64", "--json", "--quiet", "--headless", "-o", folder / "gradient.exr"});
        EXPECT_EQ(result.code, 0) << result.err;
        return nlohmann::json::parse(result.out)["memory"]["host_peak_bytes"].get<double>() / (1 << 20);
    };
    const double few = peak("8"), many = peak("64"); // each of 8 bounces
    std::cout << "8 batches: " << few << " MiB, 64: " << many << " MiB\n";
    EXPECT_LT(many, few + 32);
}

} // namespace
} // namespace cmpg
