// Light samples chosen among several: as bright as lights one by one, which leave nothing to choose, and steadier. Seeds are fixed.
#include "support/guided_fixture.h"
#include "support/scene_builder.h"

#include <algorithm>

namespace cmpg::test {
namespace {

constexpr int kEdge = 16;
constexpr std::uint32_t kSpp = 16, kPasses = 16;

PunctualLight light(PunctualLight::Kind kind, glm::vec3 position, glm::vec3 intensity) {
    PunctualLight l;
    l.kind = kind;
    l.position = position;
    l.direction = glm::normalize(glm::vec3(0.2f, -1, -0.1f));
    l.intensity = intensity;
    return l;
}

// The box without its lamp, under these lights; light that has met two surfaces.
Bench lit(const std::vector<PunctualLight>& lights) {
    Scene scene = bundledScene("box");
    for (const Material& m : scene.materials) {
        Parameter& emission = scene.parameters[m.parameters[std::size_t(SlotKind::Emission)]];
        std::fill(emission.values.begin(), emission.values.end(), 0.0f);
    }
    scene.lights = lights;
    RenderConfig config;
    config.maxDepth = 3;
    return Bench(std::move(scene), {"white.baseColor"}, config);
}

struct Means {
    MeanError image, derivative;
};

Means means(Bench& b) {
    const View view = viewOf(b.scene, kEdge, kEdge);
    std::vector<double> image, derivative;
    for (std::uint32_t i = 0; i < kPasses; ++i) {
        image.push_back(meanOf(b.renderer->render(view, kSpp, {40 + i, 0, 0})));
        derivative.push_back(meanOf(b.renderer->forward(view, kSpp, {40 + i, 0, 1}, b.config.differentiable, b.ones())));
    }
    return {statistics(image), statistics(derivative)};
}

TEST(LightChoice, SeveralLightsAreAsBrightAsOneByOne) {
    std::vector<PunctualLight> lights = {light(PunctualLight::Kind::Point, {0.5f, 0.3f, 0.2f}, glm::vec3(0.4f, 0.3f, 0.2f)),
                                         light(PunctualLight::Kind::Point, {-0.6f, -0.7f, 0.3f}, glm::vec3(0.01f)),
                                         light(PunctualLight::Kind::Spot, {-0.4f, 0.8f, 0.1f}, glm::vec3(0.5f, 1, 0.5f)),
                                         light(PunctualLight::Kind::Directional, {}, glm::vec3(0.3f))};
    lights[1].range = 2;
    Bench all = lit(lights);
    const Means together = means(all);
    MeanError image{0, 0, kPasses}, derivative{0, 0, kPasses}; // of sums: their errors are known better than that
    for (const PunctualLight& l : lights) {
        Bench alone = lit({l});
        const Means m = means(alone);
        image.mean += m.image.mean;
        image.standardError = std::hypot(image.standardError, m.image.standardError);
        derivative.mean += m.derivative.mean;
        derivative.standardError = std::hypot(derivative.standardError, m.derivative.standardError);
    }
    const auto agree = [](const MeanError& a, const MeanError& b, const char* what) {
        EXPECT_GT(a.mean, 0) << what;
        EXPECT_LT(a.standardError, 0.02 * a.mean) << what;
        expectAgreement(a, b, what);
    };
    agree(together.image, image, "image");
    agree(together.derivative, derivative, "derivative");
}

// A floor under a lamp without extent and a panel of these corner and edges.
Image underPanel(glm::vec3 lamp, glm::vec3 corner, glm::vec3 u, glm::vec3 v) {
    SceneBuilder b;
    b.square(b.material("floor", 0.5f, 0), 0);
    b.quad(b.material("panel", 0, 0), corner, u, v);
    b.camera(0.1f);
    b.scene.lights = {light(PunctualLight::Kind::Point, lamp, glm::vec3(1))};
    Bench s(std::move(b.scene), {}, RenderConfig{});
    return s.renderer->render(viewOf(s.scene, kEdge, kEdge), 4, {});
}

TEST(PointLights, ACapFarAwayCastsItsShadow) {
    EXPECT_EQ(meanOf(underPanel({0, 0, 800}, {-1, -1, 799.96f}, {2, 0, 0}, {0, 2, 0})), 0);
    EXPECT_GT(meanOf(underPanel({0, 0, 800}, {-1, -1, 800.04f}, {2, 0, 0}, {0, 2, 0})), 0) << "above the lamp";
}

// A lamp that touches a slanted ceiling lights what it lights without one.
TEST(PointLights, SitOnSurfaces) {
    const glm::vec3 corner(-3, -3, 0.4f), u(6, 0, 0.3f), v(0, 6, -0.1f);
    for (const glm::vec2 at : {glm::vec2(0.37f, 0.53f), {0.61f, 0.42f}, {0.5f, 0.5f}}) {
        const glm::vec3 lamp = corner + at.x * u + at.y * v;
        EXPECT_EQ(underPanel(lamp, corner, u, v).values, underPanel(lamp, corner + glm::vec3(0, 0, 1), u, v).values);
    }
}

// A map and lamps: as bright as what directions alone find.
TEST(LightChoice, MapsAndPanelsAreAsBrightAsWithoutLightSampling) {
    for (const char* name : {"environment", "bowl"}) {
        RenderConfig with, without;
        with.maxDepth = without.maxDepth = 3;
        without.lightSampling = false;
        Bench chosen(bundledScene(name), {"*.baseColor"}, with), found(bundledScene(name), {"*.baseColor"}, without);
        const Means a = means(chosen), b = means(found);
        expectAgreement(a.image, b.image, std::string(name) + ", image");
        expectAgreement(a.derivative, b.derivative, std::string(name) + ", derivative");
        EXPECT_LT(a.image.standardError, b.image.standardError) << name;
    }
}

} // namespace
} // namespace cmpg::test
