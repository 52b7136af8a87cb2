// Anisotropic microfacets in scenes: derivatives, directions from files and by rotation, and what scenes without them pay.
#include "base/error.h"
#include "scene/features.h"
#include "shared/material.h"
#include "support/derivative_fixture.h"
#include "support/material_json.h"

#include <numbers>

namespace cmpg::test {
namespace {

Material& materialNamed(Scene& scene, const std::string& name) {
    const auto found = std::find_if(scene.materials.begin(), scene.materials.end(), [&](const Material& m) { return m.name == name; });
    if (found == scene.materials.end())
        throw std::logic_error("no material " + name);
    return *found;
}

// Over textures, a normal map, a metal and a mix of both; one with a textured strength, one with directions by place.
Scene brushedScene() {
    Scene scene = bundledScene("materials");
    const std::vector<std::tuple<std::string, float, float>> brushed{{"varied", 0.6f, 0.4f}, {"wavy", 0.5f, -0.9f}, {"brass", 0.8f, 0.0f}, {"half", 0.3f, 2.0f}};
    for (const auto& [name, strength, rotation] : brushed)
        addAnisotropy(scene, materialNamed(scene, name), strength, rotation);
    Parameter& textured = scene.parameters[scene.parameter("varied.anisotropy")];
    Parameter like = scene.parameters[scene.parameter("varied.metallic")];
    like.materialise();
    like.name = textured.name;
    like.kind = textured.kind;
    textured = like;
    DirectionTexture& places = scene.directionTextures[materialNamed(scene, "wavy").anisotropyDirection];
    places.width = 3;
    places.height = 2;
    places.directions = {{0.5f, 0}, {0.3f, 0.4f}, {0, 0.7f}, {-0.2f, 0.4f}, {0.1f, -0.6f}, {0.6f, 0.2f}};
    return withBothLobes(std::move(scene));
}

class AnisotropyDerivative : public testing::TestWithParam<std::string> {};

TEST_P(AnisotropyDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(brushedScene(), {GetParam()})); }

TEST_P(AnisotropyDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    expectFrozenDifferences(Bench(brushedScene(), {GetParam()}, config));
}

INSTANTIATE_TEST_SUITE_P(Slots, AnisotropyDerivative, testing::Values("*.anisotropy", "*.roughness", "*.metallic", "*.normal"), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// Two alphas, on the models that have them: a conductor, both kinds of microfacets, and a dielectric.
Scene withTwoAlphas() {
    Scene scene = bundledScene("materials");
    for (const auto& [name, model, microfacets] : {std::tuple("varied", SurfaceModel::Conductor, Microfacets::Ggx), std::tuple("brass", SurfaceModel::Conductor, Microfacets::Beckmann),
                                                   std::tuple("half", SurfaceModel::Dielectric, Microfacets::Ggx)}) {
        Material& m = materialNamed(scene, name);
        m.model = model;
        m.microfacets = microfacets;
        m.eta = {0.2f, 0.4f, 1.4f};
        m.k = {4, 2.4f, 1.6f};
        setConstant(scene, m, SlotKind::Roughness, {0.3f});
        setConstant(scene, m, SlotKind::Specular, {0.9f, 0.9f, 0.9f});
        addAnisotropy(scene, m, 0.5f, 0.7f);
    }
    for (Parameter& p : scene.parameters)
        p.materialise();
    return scene;
}

// By both at once.
TEST(TwoAlphas, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(withTwoAlphas(), {"*.anisotropy", "*.roughness"})); }

TEST(TwoAlphas, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    expectFrozenDifferences(Bench(withTwoAlphas(), {"*.anisotropy", "*.roughness"}, config));
}

// The panel alone, whose texture coordinates are not turned.
Scene brushedPanel(float strength, float rotation) {
    Scene scene = bundledScene("materials");
    addAnisotropy(scene, materialNamed(scene, "varied"), strength, rotation);
    return scene;
}

TEST(Anisotropy, DirectionsAreTurnedCounterClockwise) {
    const float quarter = std::numbers::pi_v<float> / 2;
    const Image along = smallImage(brushedPanel(0.8f, 0)), across = smallImage(brushedPanel(0.8f, quarter)), diagonal = smallImage(brushedPanel(0.8f, quarter / 2));
    EXPECT_GT(relativeDifference(along, across), 0.003);
    // By a direction in place of an angle, whatever its length, and its opposite, which means the same but draws other directions.
    Scene scene = brushedPanel(0.8f, 0);
    scene.directionTextures[0].directions = {{0.3f, 0.3f}};
    EXPECT_LT(relativeDifference(smallImage(scene), diagonal), 1e-3);
    scene.directionTextures[0].directions = {{-0.3f, 0.3f}};
    EXPECT_GT(relativeDifference(smallImage(scene), diagonal), 0.003);
    // By tangents of the file: along the axis that texture coordinates give, the image is the same; turned by a quarter, it is that of a rotation.
    scene = brushedPanel(0.8f, 0);
    Geometry& g = scene.geometry;
    g.tangents.assign(g.positions.size(), glm::vec4(0));
    for (const Triangle& t : g.triangles) {
        if (scene.materials[t.material].name != "varied")
            continue;
        const auto [a, b, c] = t.vertices;
        const glm::vec2 u = g.uv0[b] - g.uv0[a], v = g.uv0[c] - g.uv0[a];
        const glm::vec3 e = g.positions[b] - g.positions[a], f = g.positions[c] - g.positions[a];
        const glm::vec3 alongV = glm::normalize((f * u.x - e * v.x) / (u.x * v.y - u.y * v.x));
        for (const std::uint32_t k : t.vertices)
            g.tangents[k] = glm::vec4(-alongV, 1); // v runs down the picture
    }
    EXPECT_LT(relativeDifference(smallImage(scene), across), 1e-3);
    // By the second texture coordinates, whose axes are turned as much.
    scene = brushedPanel(0.8f, 0);
    scene.directionTextures[0].texcoord = 1;
    for (const glm::vec2 uv : scene.geometry.uv0)
        scene.geometry.uv1.emplace_back(-uv.y, uv.x);
    EXPECT_LT(relativeDifference(smallImage(scene), across), 1e-3);
}

// Where a material has no strength nothing is asked of the kernels, and the image is that of the scene without.
TEST(Anisotropy, OfNoStrengthCostsNothing) {
    EXPECT_EQ(smallImage(brushedPanel(0, 1)).values, smallImage(bundledScene("materials")).values);
    EXPECT_EQ(analyse(brushedPanel(0, 1), {}).texturedSlots, analyse(bundledScene("materials"), {}).texturedSlots);
}

TEST(Anisotropy, OnlyWhereAMaterialHasIt) {
    const std::uint32_t bit = 1u << gpu::kSlotAnisotropy;
    const Scene plain = bundledScene("materials");
    EXPECT_EQ(analyse(plain, {}).texturedSlots & bit, 0u);
    EXPECT_EQ(analyse(brushedScene(), {}).texturedSlots & bit, bit);
    const Scene none = brushedPanel(0, 0);
    EXPECT_EQ(analyse(none, {.differentiable = {none.parameter("varied.anisotropy")}}).texturedSlots & bit, bit);
    EXPECT_THROW(plain.select("*.anisotropy"), Error);
}

} // namespace
} // namespace cmpg::test
