// Scenes of the library, as other programs use it: by its headers and its shared object alone.
#include "library_fixture.h"

#include <cmath>

namespace cmpg::test {
namespace {

TEST(LibraryScene, ValuesAreRangesAndShapesOfTheFile) {
    Scene scene = Scene::load(kBox);
    const ParameterInfo info = scene.parameter(kPainting);
    EXPECT_EQ(info.slot, "baseColor");
    EXPECT_EQ(info.height, 64);
    EXPECT_EQ(info.width, 64);
    EXPECT_EQ(info.channels, 3);
    EXPECT_EQ(info.lowest, 0);
    EXPECT_EQ(info.highest, 1);
    EXPECT_TRUE(std::isinf(scene.parameter("light.emission").highest));
    EXPECT_EQ(scene.parameters().size(), scene.select("*").size());
    EXPECT_EQ(scene.cameras().front().name, "front");

    std::vector<float> values = scene.values(kPainting);
    ASSERT_EQ(values.size(), info.entries());
    std::reverse(values.begin(), values.end());
    const Scene before = scene.copy();
    scene.set(kPainting, values);
    EXPECT_EQ(scene.values(kPainting), values);
    EXPECT_NE(before.values(kPainting), values);
    scene.set(kPainting, std::vector{0.1f, 0.2f, 0.3f});
    EXPECT_EQ(scene.values(kPainting)[4], 0.2f);
}

TEST(LibraryScene, TexturesTakeOtherSizes) {
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, {.paths = {.maxDepth = 2}, .parameters = {kPainting}});
    const PassOptions pass{.width = 16, .spp = 2};
    const Image sharp = renderer.render(pass);
    scene.resize(kPainting, 4, 2);
    EXPECT_EQ(scene.parameter(kPainting).width, 4);
    EXPECT_EQ(scene.parameter(kPainting).height, 2);
    ParameterInfo info;
    EXPECT_EQ(scene.values(kPainting, &info).size(), 24u);
    EXPECT_EQ(info.entries(), 24u);
    EXPECT_EQ(info.name, kPainting);
    const Image coarse = renderer.render(pass); // which was not told of it
    EXPECT_NE(coarse.values, sharp.values);
    EXPECT_EQ(coarse.values, Renderer(device(), scene.copy(), {.paths = {.maxDepth = 2}}).render(pass).values);
    EXPECT_EQ(renderer.backward(coarse, {.spp = 2})[0].size(), 24u);
    scene.resize("painting.roughness", 4, 4); // a constant, and no parameter of the renderer: what it looks like stays
    const Image same = renderer.render(pass);
    for (std::size_t i = 0; i < same.values.size(); ++i)
        ASSERT_NEAR(same.values[i], coarse.values[i], 1e-5f * (1 + coarse.values[i])) << i;

    EXPECT_EQ(errorOf([&] { scene.resize(kPainting, 0, 4); }).options, std::vector<std::string>{"width"});
    EXPECT_EQ(errorOf([&] { scene.resize(kPainting, 4, 99999); }).options, std::vector<std::string>{"height"});
    const Error refused = errorOf([&] { scene.resize("painting.normal", 4, 4); });
    EXPECT_EQ(refused.kind, ErrorKind::Usage);
    EXPECT_FALSE(refused.remedy.empty());
}

TEST(LibraryScene, ErrorsCarryKindCauseAndRemedy) {
    Scene scene = Scene::load(kBox);
    const Error unknown = errorOf([&] { scene.values("paintin.baseColor"); });
    EXPECT_EQ(unknown.kind, ErrorKind::Usage);
    EXPECT_NE(unknown.cause.find(kPainting), std::string::npos) << unknown.cause;
    EXPECT_FALSE(unknown.remedy.empty());
    EXPECT_EQ(errorOf([&] { scene.set(kPainting, std::vector{1.5f}); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { scene.set(kPainting, std::vector<float>(7)); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { scene.exportTo("/proc/none"); }).kind, ErrorKind::Output);
    const Error missing = errorOf([] { Scene::load("/nowhere/scene.gltf"); });
    EXPECT_EQ(missing.kind, ErrorKind::Input);
    EXPECT_FALSE(missing.cause.empty());
    EXPECT_FALSE(missing.remedy.empty());
    const Error device = errorOf([] { Device("no such device"); });
    EXPECT_EQ(device.kind, ErrorKind::Device);
    EXPECT_EQ(device.options, std::vector<std::string>{"device"});
    const Error memory = errorOf([&] { Renderer(test::device(), scene, {.paths = {.memory = 1}}); });
    EXPECT_EQ(memory.options, std::vector<std::string>{"memory"});
    for (const Error& error : {unknown, missing, device, memory}) // which are the command line's
        EXPECT_EQ((error.what() + error.cause + error.remedy).find("--"), std::string::npos) << error.remedy;
}

TEST(LibraryScene, ExportsWhatWasSet) {
    const Folder folder;
    greyScene().exportTo(folder / "out");
    EXPECT_EQ(loadImage(folder / "out/parameters/painting.baseColor.exr").values, std::vector<float>(64 * 64 * 3, 0.5f));
    for (const float value : Scene::load(folder / "out/scene.gltf").values(kPainting))
        ASSERT_NEAR(value, 0.5f, 0.003f);
}

} // namespace
} // namespace cmpg::test
