// Sensors and lights of Mitsuba scenes.
#include "mitsuba_scene.h"

namespace cmpg::test {
namespace {

TEST(Mitsuba, FieldsOfView) {
    const TempFolder folder;
    const auto half = [&](const std::string& axis, int width, int height) {
        const Scene s = loadText(folder, kSquare + "<sensor type=\"perspective\"><float name=\"fov\" value=\"60\"/><string name=\"fov_axis\" value=\"" + axis +
                                             "\"/><film type=\"hdrfilm\"><integer name=\"width\" value=\"" + std::to_string(width) +
                                             "\"/><integer name=\"height\" value=\"" + std::to_string(height) + "\"/><rfilter type=\"box\"/></film></sensor>");
        EXPECT_EQ(s.cameras.front().size, glm::uvec2(width, height));
        return std::tan(double(s.cameras.front().yfov) / 2) / std::tan(glm::radians(30.0));
    };
    EXPECT_NEAR(half("y", 200, 100), 1, 1e-6);
    EXPECT_NEAR(half("x", 200, 100), 0.5, 1e-6);
    EXPECT_NEAR(half("smaller", 200, 100), 1, 1e-6);
    EXPECT_NEAR(half("larger", 200, 100), 0.5, 1e-6);
    EXPECT_NEAR(half("smaller", 100, 200), 2, 1e-6);
    EXPECT_NEAR(half("diagonal", 200, 100), 1 / std::sqrt(5.0), 1e-6);
}

// As Mitsuba 3.9.1 has the cameras of these scenes: its left is the frame's first column, and the opposite of ours.
TEST(Mitsuba, CamerasWithoutUpStandAsTheirs) {
    const TempFolder folder;
    struct Case {
        const char *origin, *target;
        glm::vec3 left, up;
    };
    const Case cases[] = {{"1, 2, 3", "0, 0, 0", {-0.0792865f, 0.841427f, -0.534522f}, {0.960357f, -0.0792865f, -0.267261f}},
                          {"0, 0, 0", "0, 0, 1", {0, -1, 0}, {1, 0, 0}},
                          {"0, 0, 0", "0, 0, -1", {0, 1, 0}, {1, 0, 0}},
                          {"4, -1, 0.5", "-1, 2, 2", {-0.331263f, -0.801242f, 0.498273f}, {0.447894f, 0.331263f, 0.830455f}},
                          {"0, 3, 6", "0, 0.4, 0", {0, 0.917556f, -0.397607f}, {1, 0, 0}}};
    for (const Case& c : cases)
        for (const char* up : {"", " up=\"0, 0, 0\""}) {
            const Scene s = loadText(folder, kSquare + "<sensor type=\"perspective\"><transform name=\"to_world\"><lookat origin=\"" + c.origin + "\" target=\"" + c.target + "\"" +
                                                 up + "/></transform></sensor>");
            expectVec(-glm::vec3(s.cameras[0].toWorld[0]), c.left, 2e-6f);
            expectVec(glm::vec3(s.cameras[0].toWorld[1]), c.up, 2e-6f);
        }
}

TEST(Mitsuba, PlanesThatCutTheSceneAreNamed) {
    const TempFolder folder;
    const auto load = [&](const std::string& planes) { // the square is 4 before the camera
        return loadText(folder, kSquare + "<sensor type=\"perspective\">" + planes + "<transform name=\"to_world\"><translate z=\"-4\"/></transform></sensor>");
    };
    EXPECT_TRUE(warned(load("<float name=\"near_clip\" value=\"5\"/>"), "near_clip"));
    EXPECT_TRUE(warned(load("<float name=\"far_clip\" value=\"3\"/>"), "far_clip"));
    EXPECT_FALSE(warned(load("<float name=\"near_clip\" value=\"3\"/><float name=\"far_clip\" value=\"5\"/>"), "clip"));
}

TEST(Mitsuba, FocalLengths) {
    const TempFolder folder;
    const std::string film = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/><integer name=\"height\" value=\"100\"/></film>";
    // Half the diagonal at distance 1, times the focal length: that of film of 36 mm by 24 mm.
    const auto diagonal = [&](const std::string& more) {
        const Scene s = loadText(folder, kSquare + "<sensor type=\"perspective\">" + more + film + "</sensor>");
        return std::sqrt(5.0) * std::tan(double(s.cameras.front().yfov) / 2);
    };
    const double half = std::hypot(18, 12);
    EXPECT_NEAR(diagonal("<string name=\"focal_length\" value=\"35mm\"/>"), half / 35, 1e-6);
    EXPECT_NEAR(diagonal(""), half / 50, 1e-6) << "Mitsuba's default";
    EXPECT_NEAR(diagonal("<string name=\"fov_axis\" value=\"y\"/>"), half / 50, 1e-6) << "the axis is of fov";
}

TEST(Mitsuba, OrthographicSensorsWithoutSquarePixelsAreNamed) {
    const TempFolder folder;
    const auto load = [&](const std::string& scale) {
        return loadText(folder, kSquare + "<sensor type=\"orthographic\"><transform name=\"to_world\"><scale " + scale +
                                    "/><rotate x=\"1\" angle=\"40\"/></transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"200\"/>"
                                    "<integer name=\"height\" value=\"100\"/></film></sensor>");
    };
    for (const char* scale : {"value=\"3\"", "x=\"3\" y=\"-3\" z=\"1\""}) {
        const Scene s = load(scale);
        EXPECT_NEAR(s.cameras.front().ymag, 1.5, 1e-6) << scale;
        EXPECT_FALSE(warned(s, "orthographic")) << scale;
    }
    EXPECT_TRUE(warned(load("x=\"3\" y=\"2\""), "pixels are square here"));
}

TEST(Mitsuba, ReconstructionFilters) {
    const TempFolder folder;
    const auto filter = [&](const std::string& film) {
        const Scene s = loadText(folder, kSquare + "<sensor type=\"perspective\">" + film + "</sensor>");
        EXPECT_FALSE(warned(s, "not rendered"));
        return s.cameras.front().filter;
    };
    const auto film = [](const std::string& contents) { return "<film type=\"hdrfilm\">" + contents + "</film>"; };
    for (const std::string& text : {std::string(), film(""), film("<rfilter type=\"gaussian\"/>")}) {
        EXPECT_EQ(filter(text).kind, PixelFilter::Kind::Gaussian) << text << ": Mitsuba's default";
        EXPECT_EQ(filter(text).radius, 2);
        EXPECT_EQ(filter(text).deviation, 0.5f);
    }
    EXPECT_EQ(filter(film("<rfilter type=\"gaussian\"><float name=\"stddev\" value=\"0.7\"/></rfilter>")).radius, 2.8f);
    EXPECT_EQ(filter(film("<rfilter type=\"tent\"/>")).kind, PixelFilter::Kind::Tent);
    EXPECT_EQ(filter(film("<rfilter type=\"tent\"><float name=\"radius\" value=\"1.5\"/></rfilter>")).radius, 1.5f);
    EXPECT_EQ(filter(film("<rfilter type=\"box\"/>")).kind, PixelFilter::Kind::Box);
    const Scene other = loadText(folder, kSquare + "<sensor type=\"perspective\">" + film("<rfilter type=\"mitchell\"/>") + "</sensor>");
    EXPECT_EQ(other.cameras.front().filter.kind, PixelFilter::Kind::Box);
    EXPECT_TRUE(warned(other, "mitchell"));
    expectRefused(folder, "<sensor type=\"perspective\">" + film("<rfilter type=\"tent\"><float name=\"radius\" value=\"1e9\"/></rfilter>") + "</sensor>", "outside of");
}

TEST(Mitsuba, LightsRefuseTextures) {
    const TempFolder folder;
    const std::string bitmap = "type=\"bitmap\"><string name=\"filename\" value=\"picture.png\"/></texture></emitter>";
    expectRefused(folder, "<emitter type=\"point\"><texture name=\"intensity\" " + bitmap + kSquare, "a texture as intensity");
    expectRefused(folder, "<emitter type=\"spot\"><texture name=\"texture\" " + bitmap + kSquare, "a texture of a spot");
    expectRefused(folder, "<emitter type=\"spot\"><texture name=\"slide\" " + bitmap + kSquare, "a texture of a spot");
}

} // namespace
} // namespace cmpg::test
