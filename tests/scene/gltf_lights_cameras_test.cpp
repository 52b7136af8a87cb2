// Cameras, punctual lights and the environment of glTF scenes.
#include "gltf_writer.h"
#include "scene/image.h"
#include "test_images.h"

#include <cmath>

namespace cmpg::test {
namespace {

TEST(GltfCameras, PerspectiveAndOrthographic) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    w.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"aspectRatio", 1.5}, {"znear", 0.1}}}},
                         {{"name", "flat"}, {"type", "orthographic"}, {"orthographic", {{"xmag", 3}, {"ymag", -2}}}}};
    const float h = std::sqrt(0.5f);
    // Turned by 90 degrees about y, so that -Z becomes -X; the scale must not reach the frame.
    w.json["nodes"] = {{{"mesh", 0}, {"children", {1, 2, 3}}},
                       {{"camera", 0}, {"name", "eye"}, {"translation", {1, 2, 3}}, {"rotation", {0, h, 0, h}}, {"scale", {2, 3, 4}}},
                       {{"camera", 1}},
                       {{"camera", 0}, {"name", "eye"}}};
    const Scene s = loadScene(w.write(folder));
    ASSERT_EQ(s.cameras.size(), 3u);
    EXPECT_FALSE(warned(s, "camera"));
    const Camera& eye = s.camera("");
    EXPECT_EQ(eye.name, "eye");
    EXPECT_FLOAT_EQ(eye.yfov, 0.7f);
    EXPECT_FLOAT_EQ(*eye.aspect, 1.5f);
    expectVec(glm::vec3(eye.toWorld * glm::vec4(0, 0, -1, 0)), {-1, 0, 0});
    expectVec(glm::vec3(eye.toWorld * glm::vec4(0, 1, 0, 0)), {0, 1, 0});
    expectVec(glm::vec3(eye.toWorld[3]), {1, 2, 3});
    const Camera& flat = s.camera("flat");
    EXPECT_TRUE(flat.orthographic);
    EXPECT_FLOAT_EQ(flat.ymag, 2);
    EXPECT_FLOAT_EQ(*flat.aspect, 1.5f);
    EXPECT_EQ(s.camera("eye#2").yfov, 0.7f);
}

TEST(GltfCameras, DefaultCameraSeesEveryCorner) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    w.json["nodes"][0]["matrix"] = {5, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, -1, 4, 2, 1};
    const Scene s = loadScene(w.write(folder));
    ASSERT_EQ(s.cameras.size(), 1u);
    EXPECT_TRUE(warned(s, "no camera"));
    const glm::mat4 toCamera = glm::inverse(s.cameras[0].toWorld);
    for (const glm::vec3& p : s.geometry.positions) {
        const glm::vec3 c(toCamera * glm::vec4(p, 1));
        EXPECT_LT(c.z, 0);
        EXPECT_LT(std::max(std::abs(c.x), std::abs(c.y)) / -c.z, std::tan(s.cameras[0].yfov / 2));
    }
}

TEST(GltfLights, AllKinds) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    const float h = std::sqrt(0.5f);
    w.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 20}, {"range", 7}},
        {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.6}}}},
        {{"type", "directional"}, {"intensity", 3}}};
    const auto node = [](int light) { return Json{{"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}}; };
    w.json["nodes"] = {{{"mesh", 0}, {"children", {1, 2, 3}}}, node(0), node(1), node(2)};
    w.json["nodes"][1]["translation"] = {1, 2, 3};
    w.json["nodes"][3]["rotation"] = {-h, 0, 0, h}; // -90 degrees about x: -Z becomes -Y
    const Scene s = loadScene(w.write(folder));
    ASSERT_EQ(s.lights.size(), 3u);
    EXPECT_EQ(s.lights[0].kind, PunctualLight::Kind::Point);
    expectVec(s.lights[0].intensity, {20, 10, 0});
    expectVec(s.lights[0].position, {1, 2, 3});
    EXPECT_EQ(s.lights[0].range, 7);
    EXPECT_EQ(s.lights[1].kind, PunctualLight::Kind::Spot);
    EXPECT_FLOAT_EQ(s.lights[1].innerCos, std::cos(0.3f));
    EXPECT_FLOAT_EQ(s.lights[1].outerCos, std::cos(0.6f));
    expectVec(s.lights[1].direction, {0, 0, -1});
    EXPECT_EQ(s.lights[2].kind, PunctualLight::Kind::Directional);
    expectVec(s.lights[2].direction, {0, -1, 0});
    expectVec(s.lights[2].intensity, {3, 3, 3});
    EXPECT_FALSE(warned(s, "no light"));
}

TEST(GltfLights, SpotsMayHaveSharpEdges) {
    const TempFolder folder;
    const auto load = [&](double inner, double outer) {
        GltfWriter w = oneTriangle();
        w.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}}};
        w.json["nodes"] = {{{"mesh", 0}, {"children", {1}}}, {{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}}};
        return loadScene(w.write(folder));
    };
    const Scene sharp = load(0.5, 0.5);
    EXPECT_EQ(sharp.lights.at(0).innerCos, std::cos(0.5f));
    EXPECT_EQ(sharp.lights.at(0).outerCos, std::cos(0.5f));
    EXPECT_TRUE(warned(sharp, "as wide as"));
    EXPECT_FALSE(warned(load(0.4, 0.5), "cone"));
    EXPECT_THROW(load(0.6, 0.5), Error);
    EXPECT_THROW(load(0, 0), Error);
}

TEST(GltfEnvironment, IntensityIsFoldedInAndRotationKept) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    saveExr(folder / "my sky.exr", 2, 1, "RGB", {1, 2, 3, 4, -5, 6});
    w.json["scenes"][0]["extras"] = {{"environment", {{"uri", "my%20sky.exr"}, {"intensity", 2}, {"rotation", 0.5}}}, {"maxDepth", 3}};
    const Scene s = loadScene(w.write(folder));
    ASSERT_TRUE(s.environment);
    EXPECT_EQ(s.environment->rotation, 0.5f);
    EXPECT_EQ(s.environment->parameter, 6u) << "after the parameters of the materials";
    const Parameter& p = find(s, "environment.radiance");
    EXPECT_EQ(p.values, (std::vector<float>{2, 4, 6, 8, 0, 12}));
    EXPECT_EQ(p.width, 2u);
    EXPECT_EQ(p.height, 1u) << "a single row holds for all latitudes";
    EXPECT_TRUE(warned(s, "1 negative values"));
    EXPECT_EQ(s.maxDepth, 3u);
}

} // namespace
} // namespace cmpg::test
