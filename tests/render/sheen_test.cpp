// Sheens in scenes: derivatives, energy, and what scenes without them pay.
#include "base/error.h"
#include "scene/features.h"
#include "shared/material.h"
#include "support/derivative_fixture.h"
#include "support/material_json.h"

namespace cmpg::test {
namespace {

// Over textures, a normal map, a metal and a mix of both; one under a clear coat, one with textures of its own.
Scene velvetScene() {
    Scene scene = bundledScene("materials");
    const std::vector<std::tuple<std::string, glm::vec3, float>> sheens{
        {"varied", {0.5f, 0.3f, 0.4f}, 0.5f}, {"wavy", {0.8f, 0.6f, 0.3f}, 0.6f}, {"brass", {0.2f, 0.7f, 0.9f}, 0.3f}, {"half", {0.3f, 0.2f, 0.5f}, 0.4f}};
    for (const auto& [name, color, roughness] : sheens)
        for (Material& m : scene.materials)
            if (m.name == name) {
                addSheen(scene, m, color, roughness);
                if (name == "half")
                    addClearCoat(scene, m, 0.5f, 0.4f);
            }
    for (const auto& [to, from] : {std::pair("varied.sheenRoughness", "varied.roughness"), std::pair("varied.sheenColor", "varied.baseColor")}) {
        Parameter like = scene.parameters[scene.parameter(from)];
        like.materialise();
        Parameter& textured = scene.parameters[scene.parameter(to)];
        like.name = textured.name;
        like.kind = textured.kind;
        textured = like;
        const bool color = textured.kind == SlotKind::SheenColor; // whose largest channel stays the largest
        for (std::size_t k = 0; k < textured.values.size(); ++k)
            textured.values[k] = color && k % 3 != 0 ? 0.3f * textured.values[k] : std::clamp(textured.values[k], 0.5f, 0.9f);
    }
    return withBothLobes(std::move(scene));
}

class SheenDerivative : public testing::TestWithParam<std::string> {};

TEST_P(SheenDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(velvetScene(), {GetParam()})); }

TEST_P(SheenDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    // The image hardly changes with the sheen's roughness: a larger step stands above rounding.
    expectFrozenDifferences(Bench(velvetScene(), {GetParam()}, config), GetParam() == "*.sheenRoughness" ? 1e-2f : 2e-3f);
}

INSTANTIATE_TEST_SUITE_P(Slots, SheenDerivative, testing::Values("*.sheenColor", "*.sheenRoughness", "*.baseColor", "*.normal"), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

Scene furnace(float color, float roughness) {
    Scene scene = bundledScene("furnace");
    if (color > 0)
        for (Material& m : scene.materials)
            addSheen(scene, m, glm::vec3(color), roughness);
    for (Parameter& p : scene.parameters)
        if (p.kind == SlotKind::BaseColor)
            std::fill(p.values.begin(), p.values.end(), 1.0f);
    return scene;
}

// In a closed white box a sheen adds no light, and takes what the reciprocal form of the albedo scaling loses.
TEST(Sheen, WhiteFurnace) {
    for (const float roughness : {0.4f, 1.0f}) {
        RenderConfig config;
        config.maxDepth = 4;
        Bench s(furnace(1, roughness), {}, config);
        const double emitted = s.scene.parameters[s.scene.select("*.emission").at(0)].values[0];
        std::vector<double> values;
        for (std::uint32_t i = 0; i < 8; ++i)
            values.push_back(meanOf(s.renderer->render(viewOf(s.scene, 16, 16), 64, {i, 0, 0})));
        const MeanError value = statistics(values);
        // Three standard errors (99.7 %), and the error of the fitted albedo at each of three reflections.
        EXPECT_LE(value.mean, 4 * emitted * (1 + 0.004) + 3 * value.standardError) << roughness;
        EXPECT_GE(value.mean, 4 * emitted * 0.6) << roughness;
        EXPECT_LT(value.standardError, 1e-2 * emitted) << roughness;
    }
}

Image imageOf(Scene scene) {
    Bench s(std::move(scene), {});
    return s.renderer->render(viewOf(s.scene, 24, 24), 16, {3, 0, 0});
}

// Of black nothing is asked of the kernels, and the image is that of the scene without.
TEST(Sheen, OfNoColourCostsNothing) {
    Scene scene = bundledScene("materials");
    for (Material& m : scene.materials)
        addSheen(scene, m, glm::vec3(0), 0.5f);
    EXPECT_EQ(imageOf(scene).values, imageOf(bundledScene("materials")).values);
    EXPECT_EQ(analyse(scene, {}).texturedSlots, analyse(bundledScene("materials"), {}).texturedSlots);
}

TEST(Sheen, OnlyWhereAMaterialHasOne) {
    const std::uint32_t bits = 1u << gpu::kSlotSheenColor | 1u << gpu::kSlotSheenRoughness;
    const Scene plain = bundledScene("materials");
    EXPECT_EQ(analyse(plain, {}).texturedSlots & bits, 0u);
    EXPECT_EQ(analyse(velvetScene(), {}).texturedSlots & bits, bits);
    Scene black = bundledScene("furnace");
    addSheen(black, black.materials[0], glm::vec3(0), 0.5f);
    const std::string color = black.materials[0].name + ".sheenColor";
    EXPECT_EQ(analyse(black, {.differentiable = {black.parameter(color)}}).texturedSlots & bits, bits);
    EXPECT_THROW(plain.select("*.sheenColor"), Error);
}

} // namespace
} // namespace cmpg::test
