// What all formats of scene files have in common: how a format is found, and the environment that is given beside the file.
#include "gltf_writer.h"
#include "scene/image.h"
#include "scene/pixel_filter.h"
#include "test_images.h"

#include <atomic>
#include <fstream>
#include <numbers>
#include <thread>

namespace cmpg::test {
namespace {

TEST(SceneFile, FormatFollowsFromExtensionThenContent) {
    EXPECT_TRUE(isSceneName("a/room.gltf"));
    EXPECT_TRUE(isSceneName("ROOM.GLB"));
    EXPECT_FALSE(isSceneName("room.exr"));
    const TempFolder folder;
    const fs::path scene = oneTriangle().write(folder), renamed = folder / "scene.txt";
    fs::copy_file(scene, renamed);
    EXPECT_EQ(loadScene(renamed).geometry.triangles.size(), 1u);
    EXPECT_EQ(std::string(loadScene(renamed).format->exported), "scene.gltf");
    writeText(renamed, oneTriangle().glb());
    EXPECT_EQ(loadScene(renamed).geometry.triangles.size(), 1u);
    EXPECT_EQ(std::string(loadScene(renamed).format->exported), "scene.gltf");
    writeText(renamed, "<scene version=\"3.0.0\"><shape type=\"rectangle\"/><sensor type=\"perspective\"/></scene>");
    EXPECT_EQ(loadScene(renamed).geometry.triangles.size(), 2u);
    EXPECT_EQ(std::string(loadScene(renamed).format->exported), "scene.xml");
}

// Programs of the library load scenes side by side, and ranks that are threads do.
TEST(SceneFile, ThreadsLoadAtOnce) {
    constexpr int kThreads = 4, kLoads = 200; // with a list that all loads shared ten runs of ten crashed
    const TempFolder folder;
    const fs::path scene = oneTriangle().write(folder);
    std::atomic<int> loaded = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < kLoads; ++i)
                loaded += int(loadScene(scene).geometry.triangles.size());
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(loaded, kThreads * kLoads);
}

TEST(SceneFile, EnvironmentIsAdded) {
    const TempFolder folder;
    const fs::path scene = oneTriangle().write(folder), sky = folder / "sky.exr";
    saveExr(sky, 2, 2, "RGB", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
    EXPECT_FALSE(loadScene(scene).environment);
    EXPECT_TRUE(warned(loadScene(scene), "no light at all"));

    LoadOptions options;
    options.environment = {sky, 0.25f};
    const Scene s = loadScene(scene, options);
    ASSERT_TRUE(s.environment);
    EXPECT_EQ(s.environment->rotation, 0.25f);
    EXPECT_EQ(find(s, "environment.radiance").values, (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
    EXPECT_FALSE(warned(s, "no light at all"));

    // It is part of the scene that is written, though the source lacks it.
    exportScene(s, {}, folder / "out");
    const Scene again = loadScene(folder / "out/scene.gltf");
    ASSERT_TRUE(again.environment);
    EXPECT_EQ(again.environment->rotation, 0.25f);
    EXPECT_EQ(find(again, "environment.radiance").values, find(s, "environment.radiance").values);
    EXPECT_EQ(again.geometry.triangles.size(), 1u);
}

TEST(SceneFile, FilterIsThatOfAllCameras) {
    const TempFolder folder;
    LoadOptions options;
    options.filter = gaussianFilter(0.7);
    const fs::path xml = folder / "scene.xml";
    std::ofstream(xml) << "<scene version=\"3.0.0\"><shape type=\"rectangle\"/><sensor type=\"perspective\"/><sensor type=\"orthographic\"><film "
                          "type=\"hdrfilm\"><rfilter type=\"mitchell\"/></film></sensor></scene>";
    EXPECT_TRUE(warned(loadScene(xml), "mitchell"));
    for (const Scene& s : {loadScene(oneTriangle().write(folder), options), loadScene(xml, options)}) {
        for (const Camera& camera : s.cameras)
            EXPECT_EQ(nameOf(camera.filter), "gaussian:0.7") << camera.name;
        EXPECT_FALSE(warned(s, "mitchell"));
    }
}

TEST(SceneFile, FiltersHaveNames) {
    using v1::ReconstructionFilter;
    const auto name = [](const std::string& text) { return nameOf(pixelFilter(ReconstructionFilter::parse(text))); };
    for (const char* text : {"box", "tent:1.5", "gaussian:0.25"})
        EXPECT_EQ(name(text), text);
    EXPECT_EQ(name("tent"), "tent:1");
    EXPECT_EQ(name("gaussian"), "gaussian:0.5");
    EXPECT_EQ(pixelFilter(ReconstructionFilter::parse("gaussian:0.7")).radius, 2.8f) << "four deviations";
    EXPECT_THROW(pixelFilter({.kind = ReconstructionFilter::Kind::Box, .width = 1}), Error);
    EXPECT_THROW(pixelFilter({.kind = ReconstructionFilter::Kind::Tent, .width = -1}), Error);
}

TEST(SceneFile, EnvironmentReplacesTheScenesOwn) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    w.json["scenes"][0]["extras"] = {{"environment", {{"uri", "missing.exr"}, {"intensity", 2}, {"rotation", 0.5}}}};
    const fs::path scene = w.write(folder), sky = folder / "sky.exr";
    saveExr(sky, 1, 2, "RGB", {1, 2, 3, 4, 5, 6});
    LoadOptions options;
    options.environment = {sky, 0};
    const Scene s = loadScene(scene, options); // the picture that it names need not be there
    EXPECT_EQ(s.environment->rotation, 0.0f);
    EXPECT_EQ(find(s, "environment.radiance").values, (std::vector<float>{1, 2, 3, 4, 5, 6}));
    options.environment.file = folder / "none.exr";
    EXPECT_THROW(loadScene(scene, options), Error);
}

} // namespace
} // namespace cmpg::test
