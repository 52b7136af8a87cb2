// Clear coats in scenes: derivatives, energy, and what scenes without them pay.
#include "base/error.h"
#include "scene/features.h"
#include "shared/material.h"
#include "support/derivative_fixture.h"
#include "support/material_json.h"

namespace cmpg::test {
namespace {

// Coats over a dielectric with textures, a normal map, a metal and a mix of both; one with a textured roughness.
Scene coatedScene() {
    Scene scene = bundledScene("materials");
    const std::vector<std::tuple<std::string, float, float>> coats{{"varied", 0.7f, 0.4f}, {"wavy", 0.5f, 0.6f}, {"brass", 0.8f, 0.3f}, {"half", 0.3f, 0.5f}};
    for (const auto& [name, factor, roughness] : coats)
        for (Material& m : scene.materials)
            if (m.name == name)
                addClearCoat(scene, m, factor, roughness);
    Parameter& textured = scene.parameters[scene.parameter("varied.clearcoatRoughness")];
    Parameter like = scene.parameters[scene.parameter("varied.roughness")];
    like.materialise();
    like.name = textured.name;
    like.kind = textured.kind;
    textured = like;
    return withBothLobes(std::move(scene));
}

class ClearCoatDerivative : public testing::TestWithParam<std::string> {};

TEST_P(ClearCoatDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(coatedScene(), {GetParam()})); }

TEST_P(ClearCoatDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    // The image hardly changes with a coat, and each scattering is linear in it: a larger step stands above rounding.
    expectFrozenDifferences(Bench(coatedScene(), {GetParam()}, config), GetParam() == "*.clearcoat" ? 2e-2f : 2e-3f);
}

INSTANTIATE_TEST_SUITE_P(Slots, ClearCoatDerivative, testing::Values("*.clearcoat", "*.clearcoatRoughness", "*.baseColor", "*.normal"), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// As that, where the coat over the normal map is smooth and another one has a normal of its own.
Scene ownNormals() {
    Scene scene = coatedScene();
    for (Material& m : scene.materials)
        if (m.name == "wavy")
            addClearcoatNormal(scene, m, {0, 0});
        else if (m.name == "varied")
            addClearcoatNormal(scene, m, {0.3f, -0.2f});
    return scene;
}

class OwnNormalDerivative : public testing::TestWithParam<std::string> {};

TEST_P(OwnNormalDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(ownNormals(), {GetParam()})); }

TEST_P(OwnNormalDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    expectFrozenDifferences(Bench(ownNormals(), {GetParam()}, config), GetParam() == "*.clearcoat" ? 2e-2f : 2e-3f);
}

INSTANTIATE_TEST_SUITE_P(Slots, OwnNormalDerivative, testing::Values("*.clearcoat", "*.clearcoatRoughness", "*.normal"), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// A coat whose own normals are those of the surface looks like one that shares them; one without waves does not.
TEST(ClearCoat, OwnNormalsOfTheSurfaceAreTheSame) {
    Scene scene = coatedScene();
    Material& wavy = *std::find_if(scene.materials.begin(), scene.materials.end(), [](const Material& m) { return m.name == "wavy"; });
    Parameter& normal = scene.parameters[wavy.parameters[std::size_t(SlotKind::Normal)]];
    normal.materialise();
    normal.nearest = true; // between texels the two interpolate differently
    scene.parameters[wavy.parameters[std::size_t(SlotKind::Clearcoat)]].values = {1};
    const Image shared = smallImage(scene);
    addClearcoatNormal(scene, wavy, {0, 0});
    const Image smooth = smallImage(scene);
    DirectionTexture& own = scene.directionTextures.back();
    own = {.width = normal.width, .height = normal.height, .texcoord = normal.texcoord, .wrapU = normal.wrapU, .wrapV = normal.wrapV, .nearest = true, .uvTransform = normal.uvTransform, .directions = {}};
    for (std::size_t i = 0; i < normal.values.size(); i += 3)
        own.directions.push_back(glm::vec2(glm::normalize(glm::vec3(normal.values[i], normal.values[i + 1], normal.values[i + 2]))));
    const Image same = smallImage(scene);
    EXPECT_LT(relativeDifference(same, shared), 1e-4);
    EXPECT_GT(relativeDifference(smooth, shared), 1e-3);
}

// A closed white box under a smooth coat keeps all light: over D segments L = D Le.
TEST(ClearCoat, WhiteFurnace) {
    Scene scene = bundledScene("furnace");
    for (Material& m : scene.materials)
        addClearCoat(scene, m, 1, 0);
    for (Parameter& p : scene.parameters)
        if (p.kind == SlotKind::BaseColor)
            std::fill(p.values.begin(), p.values.end(), 1.0f);
    const double emitted = scene.parameters[scene.select("*.emission").at(0)].values[0];
    RenderConfig config;
    config.maxDepth = 4;
    Bench s(std::move(scene), {}, config);
    std::vector<double> values;
    for (std::uint32_t i = 0; i < 8; ++i)
        values.push_back(meanOf(s.renderer->render(viewOf(s.scene, 16, 16), 64, {i, 0, 0})));
    const MeanError value = statistics(values);
    // Three standard errors (99.7 %), and what microfacets at the floor of alpha mask at grazing angles.
    EXPECT_NEAR(value.mean, 4 * emitted, 3 * value.standardError + 1e-3 * emitted);
    EXPECT_LT(value.standardError, 5e-3 * emitted);
}

TEST(ClearCoat, OnlyWhereAMaterialHasOne) {
    const std::uint32_t bits = 1u << gpu::kSlotClearcoat | 1u << gpu::kSlotClearcoatRoughness;
    const Scene plain = bundledScene("materials");
    EXPECT_EQ(analyse(plain, {}).texturedSlots & bits, 0u);
    EXPECT_EQ(analyse(coatedScene(), {}).texturedSlots & bits, bits);
    EXPECT_THROW(plain.select("*.clearcoat"), Error);
    EXPECT_EQ(analyse(coatedScene(), {}).models & gpu::kModelsCoatNormals, 0u);
    EXPECT_EQ(analyse(ownNormals(), {}).models & gpu::kModelsCoatNormals, gpu::kModelsCoatNormals);
}

} // namespace
} // namespace cmpg::test
