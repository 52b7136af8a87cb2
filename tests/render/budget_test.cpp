// The budget of --memory holds on bundled scenes, for every mode, whatever the size of the image.
#include "support/guided_fixture.h"

#include <algorithm>
#include <filesystem>
#include <iostream>

namespace cmpg::test {
namespace {

std::vector<std::string> bundledScenes() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(CMPG_SOURCE_DIR "/scenes"))
        if (std::filesystem::exists(entry.path() / "scene.gltf"))
            names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

// All passes there are: image, derivative image, gradient that records, guided gradient with split paths.
void expectBudgetHolds(const std::vector<std::string>& names, int edge, std::uint64_t budget) {
    for (const std::string& name : names) {
        Device own{Device::Options{}};
        RenderConfig config = guidedConfig();
        config.maxDepth = 6;
        config.memoryBudget = budget;
        config.guideMemory = 8 << 20;
        GuidedBench s(name, {"*.baseColor"}, edge, config, own);
        const double reference = s.train(1, 1);
        const std::uint64_t before = own.memory().byKind[std::size_t(MemoryKind::Guide)];
        s.plan = {.method = {Sampling::Conditional, true}, .record = true, .reference = reference};
        s.gradient(1, {1, 0, 1});
        s.plan = {};
        s.renderer->render(s.view, 1, {1, 0, 0}, s.plan, &s.result);
        s.renderer->forward(s.view, 1, {1, 0, 1}, s.config.differentiable, s.directions, s.plan, &s.result);
        const MemoryUse& used = own.memory();
        EXPECT_LE(used.peakByKind[std::size_t(MemoryKind::Transient)], budget) << name;
        EXPECT_LE(before, std::uint64_t(config.guideMemory) * 5 / 4) << name; // what grows with the cells comes on top
        std::cout << name << ": " << (used.peakByKind[std::size_t(MemoryKind::Transient)] >> 10) << " KiB of " << (budget >> 10) << "\n";
    }
}

// With most lobes, and with most of the guide.
TEST(Budget, HoldsOnScenes) { expectBudgetHolds({"materials", "door"}, 256, std::uint64_t(32) << 20); }
TEST(Budget, FullHoldsOnEvery) {
    const auto names = bundledScenes();
    ASSERT_GE(names.size(), 8u);
    expectBudgetHolds(names, 256, std::uint64_t(32) << 20);
    expectBudgetHolds(names, 2048, std::uint64_t(64) << 20);
}

} // namespace
} // namespace cmpg::test
