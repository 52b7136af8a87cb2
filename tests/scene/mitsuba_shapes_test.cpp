// Shapes of Mitsuba scenes: meshes of files and of the importer's own.
#include "mitsuba_scene.h"
#include "scene/mitsuba/mesh.h"
#include "test_images.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

TEST(Mitsuba, RoundShapesKeepTheirArea) {
    const auto area = [](const Mesh& mesh) {
        double sum = 0;
        for (const glm::uvec3& t : mesh.triangles)
            sum += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
        return sum;
    };
    const double pi = glm::pi<double>();
    EXPECT_NEAR(area(sphereMesh()), 4 * pi, 1e-9);
    EXPECT_NEAR(area(diskMesh()), pi, 1e-9);
    EXPECT_NEAR(area(cylinderMesh()), 2 * pi, 1e-9);
    EXPECT_NEAR(area(cubeMesh()), 24, 1e-9);
    for (const glm::dvec3& p : sphereMesh().positions)
        EXPECT_NEAR(glm::length(p), 1, 2e-3);
}

// Mitsuba emits to the side of the normals, also where a transform mirrors the shape.
TEST(Mitsuba, TrianglesFaceWhereNormalsPoint) {
    const TempFolder folder;
    for (const char* scale : {"x=\"1\"", "x=\"-1\""})
        for (const char* shape : {"rectangle", "disk", "sphere", "cylinder", "cube"}) {
            const Scene s = loadText(folder, "<shape type=\"" + std::string(shape) + "\"><transform name=\"to_world\"><scale " + scale + "/></transform></shape>");
            const Geometry& g = s.geometry;
            ASSERT_FALSE(g.triangles.empty());
            for (const Triangle& t : g.triangles) {
                const glm::vec3 a = g.positions[t.vertices[0]], b = g.positions[t.vertices[1]], c = g.positions[t.vertices[2]];
                EXPECT_GT(glm::dot(glm::cross(b - a, c - a), g.normals[t.vertices[0]] + g.normals[t.vertices[1]] + g.normals[t.vertices[2]]), 0) << shape << scale;
            }
        }
}

TEST(Mitsuba, SmoothingByAngleIsNamed) {
    const TempFolder folder;
    const std::string angle = "<float name=\"max_smooth_angle\" value=\"5\"/>";
    EXPECT_TRUE(warned(loadText(folder, "<shape type=\"cube\">" + angle + "</shape>"), "max_smooth_angle"));
    EXPECT_FALSE(warned(loadText(folder, "<shape type=\"cube\"/>"), "max_smooth_angle"));
}

TEST(Mitsuba, TexturesOfMeshesWithoutTextureCoordinatesAreNamed) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    std::ofstream(folder / "plain.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::ofstream(folder / "mapped.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    const auto load = [&](const std::string& mesh) {
        return loadText(folder, "<shape type=\"obj\"><string name=\"filename\" value=\"" + mesh + "\"/><bsdf type=\"diffuse\" id=\"wall\">"
                                "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"picture.png\"/></texture></bsdf></shape>");
    };
    EXPECT_TRUE(warned(load("plain.obj"), "wall.reflectance: a mesh with this texture has no texture coordinates"));
    EXPECT_FALSE(warned(load("mapped.obj"), "texture coordinates"));
}

TEST(Mitsuba, MergedShapesAreTheirParts) {
    const TempFolder folder;
    const std::string box = "<shape type=\"cube\" id=\"box\"><bsdf type=\"diffuse\" id=\"red\"/></shape>";
    const Scene s = loadText(folder, kSquare + "<shape type=\"merge\">" + box + "<shape type=\"rectangle\"/></shape>");
    EXPECT_EQ(s.geometry.triangles.size(), 2u + 12 + 2);
    EXPECT_LT(s.parameter("red.reflectance"), s.parameters.size());
    EXPECT_FALSE(warned(s, "not rendered"));
    EXPECT_TRUE(warned(loadText(folder, "<shape type=\"merge\">" + box + "<bsdf type=\"plastic\"/></shape>"), "<bsdf> ("));
    expectRefused(folder, "<shape type=\"merge\" id=\"a\"><ref id=\"a\"/></shape>", "a merge within a merge");
}

TEST(Mitsuba, MirroredSpheresAreTurnedInsideOut) {
    const TempFolder folder;
    const auto outwards = [&](const std::string& shape, const std::string& x, const std::string& more) {
        const Scene s = loadText(folder, "<shape type=\"" + shape + "\"><transform name=\"to_world\"><scale x=\"" + x + "\"/></transform>" + more + "</shape>");
        const Triangle& t = s.geometry.triangles.front();
        const glm::vec3 a = s.geometry.positions[t.vertices[0]], b = s.geometry.positions[t.vertices[1]], c = s.geometry.positions[t.vertices[2]];
        return glm::dot(glm::cross(b - a, c - a), a + b + c) > 0;
    };
    const std::string flip = "<boolean name=\"flip_normals\" value=\"true\"/>";
    EXPECT_TRUE(outwards("sphere", "1", ""));
    EXPECT_FALSE(outwards("sphere", "1", flip));
    EXPECT_FALSE(outwards("sphere", "-1", ""));
    EXPECT_TRUE(outwards("sphere", "-1", flip));
    EXPECT_TRUE(outwards("cube", "-1", "")) << "other shapes are not";
    EXPECT_FALSE(outwards("cube", "-1", flip));
}

TEST(Mitsuba, ObjFiles) {
    const auto read = [](const std::string& text) { return readObj(Bytes(text.begin(), text.end()), "mesh.obj"); };
    const Mesh quad = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1 4/1\n");
    EXPECT_EQ(quad.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(quad.uvs[0], glm::vec2(0, 0.75)) << "OBJ counts from the bottom";
    EXPECT_TRUE(quad.normals.empty());
    EXPECT_EQ(smoothNormals(quad.positions, quad.triangles)[2], glm::vec3(0, 0, 1));
    EXPECT_THROW(read("v 0 0 0\nf 1 2 3\n"), Error);
    EXPECT_TRUE(read("").triangles.empty());
    std::string polygon = "v 0 0 0\nf";
    for (int i = 0; i < 300; ++i)
        polygon += " 1";
    EXPECT_THROW(read(polygon + "\n"), Error);
}

// A square of a quad and one of two triangles, with every kind of number and things that nobody asked for.
class PlyFile {
  public:
    // `format`: as the file names it.
    explicit PlyFile(std::string format) : format_(std::move(format)) {
        text_ = "ply\r\nformat " + format_ + " 1.0\r\ncomment by hand\nobj_info none\n"
                "element camera 1\nproperty list uint8 float32 weights\nproperty short flags\n"
                "element vertex 5\nproperty double x\nproperty float y\nproperty int8 z\nproperty uchar red\n"
                "property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float32 t\n"
                "element nothing 4000000000\n"
                "element face 3\nproperty uchar patch\nproperty list ushort uint vertex_indices\nend_header\n";
        put(std::uint8_t(2)), put(0.5f), put(0.25f), put(std::int16_t(-300));
        endLine();
        for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}}) {
            put(double(x) + 0.125), put(float(y)), put(std::int8_t(-1)), put(std::uint8_t(200));
            put(0.0f), put(0.0f), put(-1.0f), put(float(x) / 2), put(float(y) / 4);
            endLine();
        }
        for (const std::vector<std::uint32_t>& face : {std::vector<std::uint32_t>{0, 1, 2, 3}, {1, 4, 2}, {0, 1}}) {
            put(std::uint8_t(7)), put(std::uint16_t(face.size()));
            for (const std::uint32_t corner : face)
                put(corner);
            endLine();
        }
    }
    const std::string& text() const { return text_; }

  private:
    template <class T> void put(T value) {
        if (format_ == "ascii") {
            text_ += std::to_string(value) + ' ';
            return;
        }
        std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
        if (format_ == "binary_big_endian")
            std::reverse(bytes.begin(), bytes.end());
        text_ += bytes;
    }
    void endLine() { text_ += format_ == "ascii" ? "\n" : ""; }

    std::string format_, text_;
};

Mesh plyOf(const std::string& text) { return readPly(Bytes(text.begin(), text.end()), "mesh.ply"); }

TEST(Mitsuba, PlyFiles) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
        const std::string text = PlyFile(format).text();
        const Mesh mesh = plyOf(text);
        ASSERT_EQ(mesh.positions.size(), 5u) << format;
        EXPECT_EQ(mesh.positions[2], glm::dvec3(1.125, 1, -1)) << format;
        EXPECT_EQ(mesh.normals, std::vector<glm::vec3>(5, glm::vec3(0, 0, -1))) << format;
        EXPECT_EQ(mesh.uvs[4], glm::vec2(1, 0)) << format << ": v as it stands";
        EXPECT_EQ(mesh.uvs[2], glm::vec2(0.5f, 0.25f)) << format;
        EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}, {1, 4, 2}})) << format;
        const std::size_t body = text.find("end_header\n") + 11;
        for (std::size_t length = 0; length < text.size() - 2; ++length) // the last digit and the space after it
            EXPECT_THROW(plyOf(text.substr(0, length)), Error) << format << ' ' << length << " of " << text.size() << ", header " << body;
    }
}

// A mirror turns the corners of triangles round, and generated normals with them; normals of the file stay on their side, flat faces on that of the corners.
TEST(Mitsuba, MirroredMeshesFaceWhereMitsubasDo) {
    const TempFolder folder;
    const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    save(folder, corners + "f 1 2 3\n", "plain.obj");
    save(folder, corners + "vn 0 0 1\nf 1//1 2//1 3//1\n", "normals.obj");
    save(folder, "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
                 "property list uchar int vertex_index\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n", "plain.ply");
    // The z of the side that the triangle emits to; its normals agree.
    const auto side = [&](const std::string& file, const std::string& x, const std::string& more) {
        const Geometry g = loadText(folder, "<shape type=\"" + file.substr(file.size() - 3) + "\"><string name=\"filename\" value=\"" + file +
                                                "\"/><transform name=\"to_world\"><scale x=\"" + x + "\"/></transform>" + more + "</shape>").geometry;
        const glm::uvec3 t(g.triangles[0].vertices[0], g.triangles[0].vertices[1], g.triangles[0].vertices[2]);
        const float z = glm::cross(g.positions[t.y] - g.positions[t.x], g.positions[t.z] - g.positions[t.x]).z;
        EXPECT_EQ(g.normals.empty() ? z : g.normals[t.x].z, z) << file << x << more;
        return z;
    };
    const std::string flat = "<boolean name=\"face_normals\" value=\"true\"/>", flip = "<boolean name=\"flip_normals\" value=\"true\"/>";
    for (const char* plain : {"plain.obj", "plain.ply"}) {
        EXPECT_EQ(side(plain, "1", ""), 1) << plain;
        EXPECT_EQ(side(plain, "-1", ""), -1) << plain;
        EXPECT_EQ(side(plain, "-1", flip), 1) << plain;
        EXPECT_EQ(side(plain, "-1", flat), -1) << plain;
    }
    EXPECT_EQ(side("normals.obj", "1", ""), 1);
    EXPECT_EQ(side("normals.obj", "-1", ""), 1);
    EXPECT_EQ(side("normals.obj", "-1", flip), -1);
    EXPECT_EQ(side("normals.obj", "-1", flat), -1);
}

TEST(Mitsuba, PlyFilesThatAreRefused) {
    const std::string vertices = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_index\nend_header\n", corners = "0 0 0 1 0 0 0 1 0 ";
    const auto refused = [](const std::string& text) {
        try {
            plyOf(text);
        } catch (const Error& e) {
            EXPECT_EQ(e.kind, ErrorKind::Input);
            return std::string(e.what());
        }
        return std::string("read");
    };
    EXPECT_EQ(refused(vertices + faces + corners + "3 0 1 +2"), "read");
    for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
             {vertices + faces + corners + "3 0 1 3", "that there is not"},
             {vertices + faces + corners + "3 0 1 -1", "no index"},
             {vertices + faces + corners + "3 0 1 0.5", "no index"},
             {vertices + faces + corners + "-3 0 1 2", "no count"},
             {vertices + faces + corners + "4000000000 0 1 2", "ends early"},
             {vertices + faces + "0 0 0 1 0 0 0 inf 0 3 0 1 2", "not finite"},
             {vertices + faces + "0 0 0 1 0 0 0 1e999 0 3 0 1 2", "too large"},
             {vertices + faces + "0 0 0 1 0 0 0 x 0 3 0 1 2", "is none"},
             {vertices + "end_header\n" + corners, "no faces"},
             {"ply\nformat ascii 1.0\nelement vertex 4000000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3", "ends early"},
             {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 2", "no x, y and z"},
             {"ply\nformat ascii 2.0\nend_header\n", "format ascii 2.0"},
             {"ply\nelement vertex -1\nend_header\n", "element vertex -1"},
             {"ply\nformat ascii 1.0\nelement v 1\nproperty list float int a\nend_header\n", "property list float"},
             {"ply\nend_header\n", "names no format"},
             {"ply\nproperty float x\n", "property float x"},
             {"ply" + std::string(1 << 17, '\n'), "no end within"},
             {"v 0 0 0\n", "no PLY"}})
        EXPECT_NE(refused(text).find(part), std::string::npos) << part << " | " << refused(text) << '\n' << text.substr(0, 300);
}

TEST(Mitsuba, TextureCoordinatesOfMeshesCanBeTurned) {
    const TempFolder folder;
    save(folder, PlyFile("ascii").text(), "mesh.ply");
    save(folder, "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0.25\nf 1/1 2/1 3/1\n", "mesh.obj");
    const auto v = [&](const std::string& type, const std::string& flip) {
        const Scene s = loadText(folder, "<shape type=\"" + type + "\"><string name=\"filename\" value=\"mesh." + type + "\"/>" + flip + "</shape>");
        return s.geometry.uv0[type == "ply" ? 2 : 0].y;
    };
    const std::string on = "<boolean name=\"flip_tex_coords\" value=\"true\"/>", off = "<boolean name=\"flip_tex_coords\" value=\"false\"/>";
    EXPECT_EQ(v("ply", ""), 0.25f);
    EXPECT_EQ(v("ply", off), 0.25f);
    EXPECT_EQ(v("ply", on), 0.75f);
    EXPECT_EQ(v("obj", ""), 0.75f);
    EXPECT_EQ(v("obj", on), 0.75f);
    EXPECT_EQ(v("obj", off), 0.25f);
}

} // namespace
} // namespace cmpg::test
