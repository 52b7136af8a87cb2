// Blends of two materials: images and derivatives, and what scenes without them pay.
#include "base/error.h"
#include "scene/features.h"
#include "shared/material.h"
#include "support/derivative_fixture.h"
#include "support/material_json.h"
#include "support/scene_builder.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

constexpr int kSize = 8;

// A floor of two greys under a sun, seen from above.
Scene sunlitFloor(float first, float second, float weight) {
    SceneBuilder b;
    const std::uint32_t floor = b.material("floor", first, 0);
    b.material("other", second, 0);
    b.square(floor, 0);
    b.camera(1);
    b.sun();
    addBlend(b.scene, "floor", "other", weight);
    return b.scene;
}

// Blends of all kinds of lobes in the bundled materials: with textures, a normal map, a metal, a clear coat; a weight with a texture.
Scene blendedScene() {
    Scene scene = bundledScene("materials");
    for (Material& m : scene.materials)
        if (m.name == "half")
            addClearCoat(scene, m, 0.6f, 0.4f);
    const Parameter like = scene.parameters[scene.parameter("varied.roughness")];
    Parameter& textured = addBlend(scene, "varied", "brass", 0);
    const std::string name = textured.name;
    textured = like;
    textured.materialise();
    textured.name = name;
    textured.kind = SlotKind::Weight;
    addBlend(scene, "wavy", "half", 0.3f);
    addBlend(scene, "plastic", "wavy", 0.6f);
    return withBothLobes(std::move(scene));
}

TEST(Blend, IsTheWeightedMean) {
    for (const float weight : {0.25f, 0.95f}) {
        Bench s(sunlitFloor(0.2f, 0.8f, weight), {"floor.weight"});
        const View view = viewOf(s.scene, kSize, kSize);
        std::vector<double> values, derivatives;
        for (std::uint32_t i = 0; i < 16; ++i) {
            values.push_back(meanOf(s.renderer->render(view, 16, {i, 0, 0})));
            derivatives.push_back(meanOf(s.renderer->forward(view, 16, {i, 0, 1}, s.config.differentiable, s.ones())));
        }
        const MeanError value = statistics(values), derivative = statistics(derivatives);
        const double light = 2 / glm::pi<double>();
        EXPECT_NEAR(value.mean, light * (0.2 + 0.6 * double(weight)), 4 * value.standardError + 1e-6) << weight;
        EXPECT_NEAR(derivative.mean, light * 0.6, 4 * derivative.standardError + 1e-6) << weight;
        EXPECT_LT(value.standardError, 0.01 * value.mean);
        EXPECT_LT(derivative.standardError, 0.05 * derivative.mean);
    }
}

// A lamp behind a dark pane that lets through a part of the light.
TEST(Blend, LetsThroughAPart) {
    SceneBuilder b;
    b.square(b.material("lamp", 0, 3), -1);
    b.square(b.material("dark", 0, 0), 0);
    Material& pane = b.scene.materials[b.material("pane", 1, 0)];
    pane.model = SurfaceModel::ThinDielectric;
    b.camera(1);
    addBlend(b.scene, "dark", "pane", 0.4f);
    Bench s(b.scene, {"dark.weight"});
    const View view = viewOf(s.scene, kSize, kSize);
    const double reflected = 0.04, passed = 3 * (1 - 2 * reflected / (1 + reflected)); // both of the pane's boundaries
    std::vector<double> values, derivatives;
    for (std::uint32_t i = 0; i < 16; ++i) {
        values.push_back(meanOf(s.renderer->render(view, 64, {i, 0, 0})));
        derivatives.push_back(meanOf(s.renderer->forward(view, 64, {i, 0, 1}, s.config.differentiable, s.ones())));
    }
    const MeanError value = statistics(values), derivative = statistics(derivatives);
    EXPECT_NEAR(value.mean, 0.4 * passed, 4 * value.standardError + 1e-5);
    EXPECT_NEAR(derivative.mean, passed, 4 * derivative.standardError + 1e-5);
    EXPECT_LT(value.standardError, 0.01);
}

// The way through an absorbing interior darkens what the part scatters that lets nothing through.
TEST(Blend, InteriorsAbsorbWhicheverPartIsMet) {
    SceneBuilder b;
    b.quad(b.material("floor", 0.5f, 0), {-1, 1, 0}, {2, 0, 0}, {0, -2, 0}); // its back faces the camera
    Material& glass = b.scene.materials[b.material("glass", 1, 0)];
    glass.model = SurfaceModel::Dielectric;
    glass.smooth = true;
    glass.absorption = glm::vec3(0.5f);
    b.camera(1);
    b.sun();
    addBlend(b.scene, "floor", "glass", 0);
    Bench s(b.scene, {});
    EXPECT_NEAR(meanOf(s.renderer->render(viewOf(s.scene, kSize, kSize), 4, {1, 0, 0})), 0.5 * 2 / glm::pi<double>() * std::exp(-0.5), 1e-5);
}

// Weights of 0 and 1 leave one material, to the bit.
TEST(Blend, EndsAreTheMaterialsThemselves) {
    const auto image = [](Scene scene) {
        Bench s(std::move(scene), {});
        return s.renderer->render(viewOf(s.scene, 24, 24), 8, {3, 0, 0}).values;
    };
    Scene first = bundledScene("materials"), second = bundledScene("materials");
    addBlend(first, "varied", "brass", 0);
    EXPECT_EQ(image(first), image(bundledScene("materials")));
    addBlend(second, "varied", "brass", 1);
    Scene replaced = bundledScene("materials");
    const auto index = [&](const std::string& name) {
        return std::uint32_t(std::find_if(replaced.materials.begin(), replaced.materials.end(), [&](const Material& m) { return m.name == name; }) - replaced.materials.begin());
    };
    for (Triangle& t : replaced.geometry.triangles)
        t.material = t.material == index("varied") ? index("brass") : t.material;
    EXPECT_EQ(image(second), image(replaced));
}

class BlendDerivative : public testing::TestWithParam<std::string> {};

TEST_P(BlendDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(blendedScene(), {GetParam()})); }

TEST_P(BlendDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    // The image changes little with a coat, and each scattering is linear in it and in the weight: a larger step stands above rounding.
    expectFrozenDifferences(Bench(blendedScene(), {GetParam()}, config), GetParam() == "*.weight" || GetParam() == "*.clearcoat" ? 2e-2f : 2e-3f);
}

INSTANTIATE_TEST_SUITE_P(Slots, BlendDerivative, testing::Values("*.weight", "*.baseColor", "*.roughness", "*.clearcoat", "*.normal"), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// A lamp that is a blend emits as one that is none, and is found by both techniques.
TEST(Blend, EmitsOnce) {
    Scene plain = bundledScene("box"), blend = bundledScene("box");
    addBlend(blend, "light", "white", 0.5f);
    const auto brightness = [](Scene scene, bool lightSampling, const std::vector<std::string>& parameters, bool derivative) {
        Bench s(std::move(scene), parameters, {.maxDepth = 2, .lightSampling = lightSampling});
        const View view = viewOf(s.scene, 24, 24);
        std::vector<double> values;
        for (std::uint32_t i = 0; i < 8; ++i)
            values.push_back(meanOf(derivative ? s.renderer->forward(view, 64, {i, 0, 1}, s.config.differentiable, s.ones()) : s.renderer->render(view, 64, {i, 0, 0})));
        return statistics(values);
    };
    for (const bool derivative : {false, true}) {
        const MeanError expected = brightness(plain, true, {"light.emission"}, derivative);
        for (const bool lightSampling : {false, true}) {
            const MeanError found = brightness(blend, lightSampling, {"light.emission"}, derivative);
            EXPECT_NEAR(found.mean, expected.mean, 4 * std::hypot(found.standardError, expected.standardError) + 1e-6) << derivative << lightSampling;
        }
    }
}

TEST(Blend, OnlyWhereAMaterialIsOne) {
    const std::uint32_t bit = 1u << gpu::kSlotWeight;
    const Scene plain = bundledScene("materials");
    EXPECT_EQ(analyse(plain, {}).texturedSlots & bit, 0u);
    EXPECT_EQ(analyse(blendedScene(), {}).texturedSlots & bit, bit);
    EXPECT_THROW(plain.select("*.weight"), Error);
    // What is diffuse alone beside a blend has a kernel without it.
    Scene box = bundledScene("box");
    addBlend(box, "left", "right", 0.5f);
    const FeatureSet f = analyse(box, {});
    ASSERT_TRUE(f.classes.contains(ShadingClass::Plain));
    EXPECT_EQ(f.classes.at(ShadingClass::Plain).texturedSlots & bit, 0u);
    EXPECT_EQ(f.classes.at(ShadingClass::Other).texturedSlots & bit, bit);
}

} // namespace
} // namespace cmpg::test
