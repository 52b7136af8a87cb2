// Parameters of scenes: their names, ranges and floors.
#include "gltf_writer.h"
#include "scene/parameter_values.h"
#include "test_images.h"

#include <cmath>
#include <limits>

namespace cmpg::test {
namespace {

TEST(Parameters, SelectByNameAndGlob) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    w.json["materials"] = {{{"name", "wall"}}, {{"name", "wallpaper"}}, {{"name", "floor*"}}};
    const Scene s = loadScene(w.write(folder));
    EXPECT_EQ(s.select("wall.baseColor"), (std::vector<std::uint32_t>{0}));
    EXPECT_EQ(s.select("wall*.baseColor"), (std::vector<std::uint32_t>{0, 6}));
    EXPECT_EQ(s.select("*.roughness").size(), 3u);
    EXPECT_EQ(s.select("????.metallic"), (std::vector<std::uint32_t>{2}));
    EXPECT_EQ(s.select("*").size(), 18u);
    EXPECT_EQ(s.select("floor*.baseColor"), (std::vector<std::uint32_t>{12}));
    try {
        s.select("wal.basecolor");
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Usage);
        EXPECT_NE(e.cause.find("wall.baseColor"), std::string::npos) << e.cause;
    }
    for (const char* none : {"Wall*", "x?", ""}) EXPECT_THROW(s.select(none), Error) << none;
    EXPECT_THROW(s.camera("nobody"), Error);
}

TEST(Parameters, FloorsOfRoughnessAreThoseOfTheShaders) {
    Scene s;
    s.materials.resize(2);
    s.materials[1].model = SurfaceModel::Conductor;
    for (Material& m : s.materials)
        for (const SlotKind kind : {SlotKind::BaseColor, SlotKind::Roughness, SlotKind::ClearcoatRoughness, SlotKind::SheenRoughness, SlotKind::Anisotropy}) {
            m.parameters[std::size_t(kind)] = std::uint32_t(s.parameters.size());
            s.parameters.emplace_back().kind = kind;
        }
    std::vector<float> floors;
    for (std::uint32_t p = 0; p < s.parameters.size(); ++p)
        floors.push_back(s.floorOf(p));
    const float root = std::sqrt(1e-3f);
    EXPECT_EQ(floors, (std::vector<float>{0, root, root, 0.07f, 0, 0, 1e-3f, root, 0.07f, 1e-3f})); // by the square, and by alpha
    s.parameters.emplace_back().kind = SlotKind::Radiance;
    EXPECT_EQ(s.floorOf(10), 0);
    s.materials[1].roughnessIsAlpha = false;
    EXPECT_EQ(s.floorOf(6), root);
    EXPECT_EQ(s.floorOf(9), 0);
}

// What a normal map's scale has made can be set again as it is.
TEST(Parameters, NormalsMayBeLong) {
    Parameter normal;
    normal.kind = SlotKind::Normal;
    const std::vector<float> steep = {-1.8f, 1.5f, 0.3f};
    setValues(normal, steep);
    EXPECT_EQ(normal.values, steep);
    EXPECT_THROW(setValues(normal, {std::numeric_limits<float>::infinity(), 0, 1}), Error);
    EXPECT_THROW(setValues(normal, {std::numeric_limits<float>::quiet_NaN(), 0, 1}), Error);
    EXPECT_THROW(setValues(normal, {2e6f, 0, 1}), Error);
}

TEST(Parameters, RangesBelongToTheSlot) {
    const TempFolder folder;
    const Scene s = loadScene(oneTriangle().write(folder));
    EXPECT_EQ(find(s, "wall.baseColor").highest(), 1);
    EXPECT_EQ(find(s, "wall.normal").lowest(), -1);
    EXPECT_TRUE(std::isinf(find(s, "wall.emission").highest()));
}

} // namespace
} // namespace cmpg::test
