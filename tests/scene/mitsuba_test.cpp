// Scenes in Mitsuba's XML format: what is read, what it is called, and what is refused where.
#include "gltf_writer.h"
#include "scene/mitsuba/mesh.h"
#include "test_images.h"

#include <glm/gtc/constants.hpp>

namespace cmpg::test {
namespace {

fs::path save(const TempFolder& folder, const std::string& text, const std::string& name = "scene.xml") {
    std::ofstream(folder / name) << text;
    return folder / name;
}

Scene loadText(const TempFolder& folder, const std::string& contents, const LoadOptions& options = {}) {
    return loadScene(save(folder, "<scene version=\"3.0.0\">\n" + contents + "\n</scene>\n"), options);
}

const std::string kSquare = "<shape type=\"rectangle\"><bsdf type=\"twosided\" id=\"wall\"><bsdf type=\"diffuse\">"
                            "<rgb name=\"reflectance\" value=\"0.1, 0.2 0.3\"/></bsdf></bsdf></shape>";

// The message of what loading throws.
std::string refusal(const TempFolder& folder, const std::string& contents, const LoadOptions& options = {}) {
    try {
        loadText(folder, contents, options);
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Input) << e.what();
        return std::string(e.what()) + " | " + e.remedy;
    }
    return "";
}

void expectRefused(const TempFolder& folder, const std::string& contents, const std::string& part, int line = 2) {
    const std::string message = refusal(folder, contents);
    EXPECT_NE(message.find("scene.xml:" + std::to_string(line) + ": "), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(Mitsuba, NamesParametersAsItsUsersDo) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<emitter type=\"constant\" id=\"sky\"/>");
    EXPECT_EQ(find(s, "wall.reflectance").values, (std::vector<float>{0.1f, 0.2f, 0.3f}));
    for (const char* other : {"wall.reflectance.value", "wall.brdf_0.reflectance.value", "wall.brdf_0.reflectance"})
        EXPECT_EQ(s.parameter(other), s.parameter("wall.reflectance")) << other;
    EXPECT_EQ(s.select("wall.brdf_0.reflectance.value").size(), 1u);
    EXPECT_EQ(s.parameter("sky.radiance.value"), s.environment->parameter);
    EXPECT_EQ(find(s, "environment.radiance").values, std::vector<float>(6, 1.0f)) << "a row for each pole";
    EXPECT_EQ(std::string(s.format->exported), "scene.xml");
}

TEST(Mitsuba, GlobsLeaveOutTheNormalsOfGlass) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<shape type=\"sphere\"><bsdf type=\"dielectric\" id=\"glass\"/></shape>");
    const std::uint32_t wall = s.parameter("wall.normal"), glass = s.parameter("glass.normal");
    std::vector<std::string> left;
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"*.normal"}, &left), std::vector<std::uint32_t>{wall});
    EXPECT_EQ(left, std::vector<std::string>{"glass.normal"});
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"*"}).size(), s.parameters.size() - 1);
    // Refused later, with the reason.
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"glass.normal", "glass.n*"}), std::vector<std::uint32_t>{glass});
}

TEST(Mitsuba, VariablesHaveDefaultsAndAreGivenBesideTheScene) {
    const TempFolder folder;
    const std::string scene = "<default name=\"depth\" value=\"3\"/><default name=\"kind\" value=\"path\"/>"
                              "<integrator type=\"$kind\"><integer name=\"max_depth\" value=\"$depth\"/></integrator>" + kSquare;
    EXPECT_EQ(loadText(folder, scene).maxDepth, 3u);
    LoadOptions options;
    options.definitions = {{"depth", "7"}, {"other", "1"}};
    const Scene s = loadText(folder, scene, options);
    EXPECT_EQ(s.maxDepth, 7u);
    EXPECT_TRUE(warned(s, "no variable of the scene is called other"));
    expectRefused(folder, "<integrator type=\"path\"><integer name=\"max_depth\" value=\"$depth\"/></integrator>", "$depth");
}

TEST(Mitsuba, IncludesAndReferences) {
    const TempFolder folder;
    save(folder, "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"other\"><float name=\"reflectance\" value=\"$grey\"/></bsdf></scene>", "part.xml");
    const Scene s = loadText(folder, "<default name=\"grey\" value=\"0.25\"/><include filename=\"part.xml\"/>"
                                     "<shape type=\"rectangle\"><ref id=\"other\"/></shape><shape type=\"disk\"><ref id=\"other\"/></shape>");
    EXPECT_EQ(find(s, "other.reflectance").values, std::vector<float>(3, 0.25f));
    EXPECT_EQ(s.materials.size(), 1u) << "shapes share it";
    expectRefused(folder, "<shape type=\"rectangle\"><ref id=\"none\"/></shape>", "none");
    expectRefused(folder, "\n<include filename=\"../part.xml\"/>", "leaves the scene's folder", 3);
    expectRefused(folder, "<include filename=\"/etc/passwd\"/>", "not a relative path");
    EXPECT_NE(refusal(folder, "<include filename=\"scene.xml\"/>").find("include each other"), std::string::npos);
}

TEST(Mitsuba, ShapesThatEmitShareTheirMaterialsParameters) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<shape type=\"rectangle\" id=\"lamp\"><ref id=\"wall\"/>"
                                               "<emitter type=\"area\"><rgb name=\"radiance\" value=\"3\"/></emitter></shape>");
    ASSERT_EQ(s.materials.size(), 2u);
    EXPECT_EQ(s.materials[0].parameters[0], s.materials[1].parameters[0]);
    EXPECT_NE(s.materials[0].parameters[4], s.materials[1].parameters[4]);
    EXPECT_EQ(find(s, "lamp.emitter.radiance").values, std::vector<float>(3, 3.0f));
    EXPECT_EQ(s.geometry.triangles.size(), 4u);
}

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

TEST(Mitsuba, BlendsHaveTwoMaterials) {
    const TempFolder folder;
    const std::string parts = "<ref id=\"wall\"/><bsdf type=\"roughconductor\" id=\"metal\"/>", weight = "<float name=\"weight\" value=\"0.3\"/>";
    const auto shape = [](const std::string& bsdf, const std::string& emitter = "") { return "<shape type=\"disk\" id=\"lamp\">" + bsdf + emitter + "</shape>"; };
    const auto blend = [](const std::string& contents) { return "<bsdf type=\"blendbsdf\" id=\"mix\">" + contents + "</bsdf>"; };
    const Scene s = loadText(folder, kSquare + shape(blend(weight + parts), "<emitter type=\"area\"/>"));
    for (const char* name : {"mix.weight.value", "mix.brdf_0.weight.value"})
        EXPECT_EQ(s.parameter(name), s.parameter("mix.weight")) << name;
    EXPECT_EQ(find(s, "mix.weight").values, std::vector<float>{0.3f});
    EXPECT_EQ(s.parameter("mix.bsdf_0.brdf_0.reflectance.value"), s.parameter("wall.reflectance")) << "a material is shared";
    for (const char* name : {"mix.bsdf_1.alpha.value", "mix.brdf_0.bsdf_1.alpha"})
        EXPECT_EQ(s.parameter(name), s.parameter("metal.alpha")) << name;
    const Material& first = s.materials[s.geometry.triangles.back().material];
    ASSERT_NE(first.blendWith, kNoMaterial);
    const Material& second = s.materials[first.blendWith];
    EXPECT_EQ(first.model, SurfaceModel::MetallicRoughness);
    EXPECT_EQ(second.model, SurfaceModel::Conductor);
    EXPECT_FALSE(first.oneSided);
    EXPECT_TRUE(second.oneSided);
    for (const SlotKind kind : {SlotKind::Weight, SlotKind::Emission})
        EXPECT_EQ(first.parameters[std::size_t(kind)], second.parameters[std::size_t(kind)]);
    EXPECT_EQ(s.parameters[first.parameters[std::size_t(SlotKind::Emission)]].name, "lamp.emitter.radiance");
    const Scene both = loadText(folder, kSquare + shape("<bsdf type=\"twosided\">" + blend(weight + parts) + "</bsdf>"));
    EXPECT_FALSE(both.materials[both.materials[both.geometry.triangles.back().material].blendWith].oneSided);

    // It is written back.
    Scene changed = s;
    changed.parameters[s.parameter("mix.weight")].values = {0.75f};
    exportScene(changed, {s.parameter("mix.weight")}, folder / "out");
    EXPECT_EQ(find(loadScene(folder / "out/scene.xml"), "mix.weight").values, std::vector<float>{0.75f});

    expectRefused(folder, kSquare + shape(blend(parts)), "no weight");
    expectRefused(folder, shape(blend(weight + "<bsdf type=\"diffuse\"/>")), "give it two");
    expectRefused(folder, shape(blend(weight + "<bsdf type=\"diffuse\"/><bsdf type=\"null\"/>")), "use a mask");
    expectRefused(folder, shape(blend(weight + "<bsdf type=\"diffuse\"/><bsdf type=\"mask\"><bsdf type=\"diffuse\"/></bsdf>")), "put the mask around");
    expectRefused(folder, shape(blend(weight + "<bsdf type=\"diffuse\"/><bsdf type=\"blendbsdf\"/>")), "blend two materials");
    expectRefused(folder, shape(blend(weight + "<bsdf type=\"diffuse\"/><ref id=\"mix\"/>")), ""); // itself
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

TEST(Mitsuba, SurfaceModels) {
    const TempFolder folder;
    const auto material = [&](const std::string& bsdf) { return loadText(folder, "<shape type=\"rectangle\">" + bsdf + "</shape>").materials[0]; };
    Material m = material("<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Au\"/><string name=\"distribution\" value=\"ggx\"/></bsdf>");
    EXPECT_EQ(m.model, SurfaceModel::Conductor);
    EXPECT_EQ(m.microfacets, Microfacets::Ggx);
    EXPECT_FALSE(m.smooth);
    EXPECT_NEAR(m.eta.x, 0.143, 1e-3);
    m = material("<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1.2\"/></bsdf>");
    EXPECT_EQ(m.model, SurfaceModel::Dielectric);
    EXPECT_TRUE(m.smooth);
    EXPECT_NEAR(m.ior, 1.25, 1e-6);
    m = material("<bsdf type=\"twosided\"><bsdf type=\"roughplastic\"><boolean name=\"nonlinear\" value=\"true\"/></bsdf></bsdf>");
    EXPECT_EQ(m.model, SurfaceModel::Plastic);
    EXPECT_EQ(m.microfacets, Microfacets::Beckmann);
    EXPECT_TRUE(m.nonlinear);
    EXPECT_NEAR(m.ior, 1.49 / 1.000277, 1e-6);
    EXPECT_FALSE(m.oneSided);
    EXPECT_EQ(material("<bsdf type=\"thindielectric\"/>").model, SurfaceModel::ThinDielectric);
    for (const char* type : {"diffuse", "conductor", "roughconductor", "plastic", "roughplastic", "principled"})
        EXPECT_TRUE(material("<bsdf type=\"" + std::string(type) + "\"/>").oneSided) << type;
    for (const char* type : {"dielectric", "roughdielectric", "thindielectric"})
        EXPECT_FALSE(material("<bsdf type=\"" + std::string(type) + "\"/>").oneSided) << type;
    EXPECT_TRUE(material("").oneSided) << "Mitsuba's default is diffuse";
}

TEST(Mitsuba, TwoAlphas) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {255, 255, 255, 51, 51, 51});
    const auto shape = [](const std::string& type, const std::string& inside) { return "<shape type=\"rectangle\"><bsdf type=\"" + type + "\" id=\"brushed\">" + inside + "</bsdf></shape>"; };
    const std::string u = "<float name=\"alpha_u\" value=\"0.4\"/>", v = "<float name=\"alpha_v\" value=\"0.2\"/>";
    for (const char* type : {"roughconductor", "roughdielectric"}) {
        const Scene s = loadText(folder, shape(type, u + v));
        EXPECT_TRUE(hasAnisotropy(s.materials[0])) << type;
        EXPECT_EQ(find(s, "brushed.alpha_u").kind, SlotKind::Anisotropy);
        EXPECT_EQ(find(s, "brushed.alpha_u").values, std::vector<float>{0.4f});
        EXPECT_EQ(find(s, "brushed.alpha_v").kind, SlotKind::Roughness);
        EXPECT_EQ(find(s, "brushed.alpha_v").values, std::vector<float>{0.2f});
    }
    const std::string texture = "<texture type=\"bitmap\" name=\"alpha_u\"><string name=\"filename\" value=\"picture.png\"/><boolean name=\"raw\" value=\"true\"/></texture>";
    EXPECT_FALSE(hasAnisotropy(loadText(folder, shape("roughconductor", "")).materials[0]));
    Scene s = loadText(folder, shape("roughconductor", texture + v));
    Parameter& textured = s.parameters[s.parameter("brushed.alpha_u")];
    textured.materialise();
    EXPECT_EQ(textured.values, (std::vector<float>{1, 0.2f}));
    textured.values = {0.5f, 0.25f};
    s.parameters[s.parameter("brushed.alpha_v")].values = {0.75f};
    exportScene(s, {s.parameter("brushed.alpha_u"), s.parameter("brushed.alpha_v")}, folder / "out");
    const Scene again = loadScene(folder / "out/scene.xml");
    Parameter written = find(again, "brushed.alpha_u");
    written.materialise();
    EXPECT_NEAR(written.values.at(0), 0.5f, 0.003);
    EXPECT_NEAR(written.values.at(1), 0.25f, 0.003);
    EXPECT_EQ(find(again, "brushed.alpha_v").values, std::vector<float>{0.75f});

    expectRefused(folder, shape("roughconductor", u), "go together");
    expectRefused(folder, shape("roughdielectric", v), "go together");
    expectRefused(folder, shape("roughconductor", u + v + "<float name=\"alpha\" value=\"0.1\"/>"), "beside alpha_u");
    expectRefused(folder, shape("roughplastic", u + v), "one roughness");
    const Scene principled = loadText(folder, shape("principled", "<float name=\"anisotropic\" value=\"0.5\"/>"));
    EXPECT_TRUE(hasAnisotropy(principled.materials[0]) && principled.materials[0].anisotropyByAspect);
    EXPECT_EQ(find(principled, "brushed.anisotropic").values, std::vector<float>{0.5f});
    EXPECT_FALSE(hasAnisotropy(loadText(folder, shape("principled", "")).materials[0]));
}

TEST(Mitsuba, MasksCoverInPart) {
    const TempFolder folder;
    savePng(folder / "opacity.png", 2, 1, 1, {0, 188});
    const auto load = [&](const std::string& opacity) {
        return loadText(folder, "<shape type=\"rectangle\"><bsdf type=\"mask\">" + opacity + "<bsdf type=\"diffuse\"/></bsdf></shape>");
    };
    EXPECT_EQ(load("").materials[0].alphaFactor, 0.5f) << "Mitsuba's default";
    const Scene constant = load("<float name=\"opacity\" value=\"0.25\"/>");
    EXPECT_TRUE(constant.materials[0].alphaMask && constant.materials[0].coverage);
    EXPECT_EQ(constant.materials[0].alphaFactor, 0.25f);
    EXPECT_FALSE(load("<float name=\"opacity\" value=\"1\"/>").materials[0].alphaMask);
    const auto texture = [](const std::string& more) {
        return "<texture type=\"bitmap\" name=\"opacity\"><string name=\"filename\" value=\"opacity.png\"/>" + more + "</texture>";
    };
    const Scene encoded = load(texture("")), raw = load(texture("<boolean name=\"raw\" value=\"true\"/>"));
    EXPECT_TRUE(encoded.materials[0].coverage);
    EXPECT_EQ(encoded.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 128})) << "sRGB";
    EXPECT_EQ(raw.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 188}));
}

TEST(Mitsuba, RefusesWhatItDoesNotKnow) {
    const TempFolder folder;
    expectRefused(folder, "<shape type=\"rectangle\"><bsdf type=\"hair\"/></shape>", "use diffuse, ");
    expectRefused(folder, "\n\n<shape type=\"serialized\"><string name=\"filename\" value=\"a.serialized\"/></shape>", "convert it to .ply", 4);
    expectRefused(folder, "<shape type=\"teapot\"/>", "use obj, ");
    expectRefused(folder, "<emitter type=\"sunsky\"/>", "use area, point");
    expectRefused(folder, "<sensor type=\"fisheye\"/>", "use perspective");
    expectRefused(folder, "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><texture type=\"marble\" name=\"reflectance\"/></bsdf></shape>", "use bitmap");
    expectRefused(folder, "<shape type=\"rectangle\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"a\"/></bsdf></shape>", "which is not");
    expectRefused(folder, "<shape type=\"sphere\"><float name=\"radius\" value=\"1e99\"/></shape>", "which is not");
    expectRefused(folder, "<shape type=\"obj\"><string name=\"filename\" value=\"none.obj\"/></shape>", "No such file");
    expectRefused(folder, "<medium type=\"homogeneous\"/>", "medium");
    expectRefused(folder, "<shape>", "XML", 3);
    EXPECT_TRUE(warned(loadText(folder, "<shape type=\"rectangle\"><float name=\"fuzz\" value=\"1\"/></shape>"), "fuzz ("));
}

TEST(Mitsuba, LimitsHold) {
    const TempFolder folder;
    std::string deep;
    for (int i = 0; i < 100000; ++i)
        deep += "<x>";
    EXPECT_NE(refusal(folder, deep), "");
    LoadOptions few;
    few.maxTriangles = 100;
    EXPECT_NE(refusal(folder, "<shape type=\"sphere\"/>", few).find("more than 100 triangles"), std::string::npos);
    std::string doubling = "<default name=\"a\" value=\"xx\"/>";
    for (char c = 'a'; c < 'z'; ++c)
        doubling += "<default name=\"" + std::string(1, char(c + 1)) + "\" value=\"$" + c + "$" + c + "\"/>";
    EXPECT_NE(refusal(folder, doubling).find("too long"), std::string::npos);
}

TEST(Mitsuba, ObjFiles) {
    const auto read = [](const std::string& text) { return readObj(Bytes(text.begin(), text.end()), "mesh.obj"); };
    const Mesh quad = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0.25\nf 1/1 2/1 3/1 4/1\n");
    EXPECT_EQ(quad.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_EQ(quad.uvs[0], glm::vec2(0, 0.75)) << "OBJ counts from the bottom";
    EXPECT_TRUE(quad.normals.empty());
    Mesh smooth = quad;
    addNormals(smooth);
    EXPECT_EQ(smooth.normals[2], glm::vec3(0, 0, 1));
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

TEST(Mitsuba, ExportLoadsBack) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    const std::string scene = "<default name=\"grey\" value=\"0.3\"/>" + kSquare +
                              "<shape type=\"disk\" id=\"lamp\"><emitter type=\"area\"/><bsdf type=\"roughplastic\" id=\"shiny\">"
                              "<texture type=\"bitmap\" name=\"diffuse_reflectance\"><string name=\"filename\" value=\"picture.png\"/>"
                              "<string name=\"filter_type\" value=\"nearest\"/><transform name=\"to_uv\"><scale x=\"2\"/></transform></texture></bsdf></shape>"
                              "<shape type=\"rectangle\" id=\"plain\"><bsdf type=\"diffuse\"><float name=\"reflectance\" value=\"$grey\"/></bsdf></shape>"
                              "<emitter type=\"constant\" id=\"sky\"/>";
    LoadOptions options;
    options.definitions = {{"grey", "0.4"}};
    Scene s = loadText(folder, scene, options);
    std::vector<std::uint32_t> changed;
    const auto change = [&](const std::string& name, float value) {
        Parameter& p = s.parameters[s.parameter(name)];
        p.materialise();
        std::fill(p.values.begin(), p.values.end(), value);
        changed.push_back(s.parameter(name));
    };
    change("wall.reflectance", 0.75f);
    change("lamp.emitter.radiance", 5);
    change("shiny.diffuse_reflectance", 0.5f);
    change("shiny.alpha", 0.25f);
    change("environment.radiance", 2);
    exportScene(s, changed, folder / "out");
    const Scene again = loadScene(folder / "out/scene.xml");
    ASSERT_EQ(again.parameters.size(), s.parameters.size());
    for (std::uint32_t i = 0; i < s.parameters.size(); ++i) {
        Parameter was = s.parameters[i], is = again.parameters[i];
        was.materialise();
        is.materialise();
        EXPECT_EQ(is.name, was.name);
        EXPECT_EQ(is.nearest, was.nearest) << is.name;
        EXPECT_EQ(is.uvTransform, was.uvTransform) << is.name;
        if (is.name == "environment.radiance") // as a picture
            EXPECT_EQ(is.values, std::vector<float>(4 * 2 * 3, 2.0f));
        else
            for (std::size_t k = 0; k < was.values.size(); ++k)
                EXPECT_NEAR(is.values.at(k), was.values[k], 0.005) << is.name;
    }
    EXPECT_EQ(find(again, "plain.bsdf.reflectance").values[0], 0.4f) << "what --define gave is in it";
    EXPECT_TRUE(fs::exists(folder / "out/parameters/shiny.diffuse_reflectance.exr"));
    EXPECT_THROW(exportScene(s, {}, fs::path(s.source).parent_path()), Error);
}

} // namespace
} // namespace cmpg::test
