// How light sampling picks directions of an environment, and how often it picks the environment.
#include "gltf_writer.h"
#include "test_images.h"

#include "scene/light_distribution.h"

namespace cmpg::test {
namespace {

// A triangle under a sky of 4 x 3 texels, without other lights.
Scene under(const std::vector<float>& sky, const TempFolder& folder) {
    saveExr(folder / "sky.exr", 4, 3, "RGB", sky);
    GltfWriter w = oneTriangle();
    w.json["scenes"][0]["extras"]["environment"] = {{"uri", "sky.exr"}};
    return loadScene(w.write(folder));
}

LightDistribution lightsOf(const Scene& scene, const std::vector<std::uint32_t>& differentiable = {}) {
    return buildLights(scene, buildBvh(scene.geometry), differentiable);
}

std::vector<float> grey(std::vector<float> texels) {
    std::vector<float> values;
    for (const float v : texels)
        values.insert(values.end(), 3, v);
    return values;
}

TEST(LightDistribution, LeavesWhatIsNoBrighterThanTheMeanToScatteredRays) {
    const TempFolder folder;
    // The sun is the second texel of the middle row: cells 0 and 1 of both rows have it as a corner, cells 2 and 3 do not.
    const Scene s = under(grey({1, 1, 1, 1, 1, 90, 1, 1, 1, 1, 1, 1}), folder);
    const std::vector<float> clear{0.5f, 1, /**/ 0.5f, 1, 1, 1, /**/ 0.5f, 1, 1, 1};
    const LightDistribution lights = lightsOf(s);
    // Each of the eight cells has an eighth of the sphere; the mean of the corners is 1 in four of them and 1 + 89 / 4 in the others.
    EXPECT_NEAR(lights.environmentCompensation, 3 * (1 + 89.0 / 8), 1e-4);
    ASSERT_EQ(lights.environmentCdf.size(), clear.size());
    for (std::size_t i = 0; i < clear.size(); ++i)
        EXPECT_NEAR(lights.environmentCdf[i], clear[i], 1e-6) << i;
    const LightDistribution whole = lightsOf(s, {s.environment->parameter});
    EXPECT_EQ(whole.environmentCompensation, 0) << "a dark texel's derivative is found, too";
    EXPECT_LT(whole.environmentCdf[3], 1);
}

TEST(LightDistribution, AnEvenSkyIsSampledAsItIs) {
    const TempFolder folder;
    const LightDistribution lights = lightsOf(under(grey(std::vector<float>(12, 2)), folder));
    EXPECT_EQ(lights.environmentCompensation, 0);
    EXPECT_EQ(lights.environmentProbability, 1);
    for (int i = 0; i < 4; ++i)
        EXPECT_NEAR(lights.environmentCdf.at(std::size_t(2 + i)), 0.25f * float(i + 1), 1e-6);
}

// What scattered rays find takes few light samples from the lamps.
TEST(LightDistribution, LampsGetTheLightSamplesThatAnEvenSkyDoesNotNeed) {
    const TempFolder folder;
    Scene s = under(grey(std::vector<float>(12, 2)), folder);
    const double disc = 1 / double(lightsOf(s).lights.at(0).range);
    PunctualLight lamp;
    lamp.intensity = glm::vec3(float(disc * 2 / 20)); // its power is a twentieth of the sky's
    s.lights.push_back(lamp);
    EXPECT_NEAR(lightsOf(s).environmentProbability, 0.5, 1e-5);
    EXPECT_NEAR(lightsOf(s, {s.environment->parameter}).environmentProbability, 20.0 / 21, 1e-5);
}

} // namespace
} // namespace cmpg::test
