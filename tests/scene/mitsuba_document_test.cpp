// Scenes in Mitsuba's XML format: names, variables, files, limits, and what is written back.
#include "base/log.h"
#include "mitsuba_scene.h"
#include "scene/image.h"
#include "scene/parameter_values.h"
#include "test_images.h"

namespace cmpg::test {
namespace {

TEST(Mitsuba, NamesParametersAsItsUsersDo) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<emitter type=\"constant\" id=\"sky\"/>");
    EXPECT_EQ(find(s, "wall.reflectance").values, (std::vector<float>{0.1f, 0.2f, 0.3f}));
    for (const char* other : {"wall.reflectance.value", "wall.brdf_0.reflectance.value", "wall.brdf_0.reflectance"})
        EXPECT_EQ(s.parameter(other), s.parameter("wall.reflectance")) << other;
    EXPECT_EQ(s.select("wall.brdf_0.reflectance.value").size(), 1u);
    EXPECT_EQ(s.parameter("sky.radiance.value"), s.environment->parameter);
    EXPECT_EQ(find(s, "environment.radiance").values, std::vector<float>(3, 1.0f)) << "a constant, not a map";
    EXPECT_EQ(std::string(s.format->exported), "scene.xml");
}

TEST(Mitsuba, GlobsLeaveOutWhatAMaterialDoesNotRead) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<shape type=\"sphere\"><bsdf type=\"roughconductor\" id=\"metal\"/></shape>"
                                               "<shape type=\"cube\"><bsdf type=\"plastic\" id=\"shiny\"/></shape>");
    std::vector<std::string> left;
    s.selectDifferentiable(std::vector<std::string>{"metal.*", "shiny.*"}, &left);
    EXPECT_EQ(left, (std::vector<std::string>{"metal.metallic", "metal.specular", "shiny.roughness", "shiny.metallic", "shiny.normal"}));
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"metal.metallic"}).size(), 1u) << "what is meant by its name stays";
}

TEST(Mitsuba, GlobsLeaveOutTheNormalsOfGlass) {
    const TempFolder folder;
    const Scene s = loadText(folder, kSquare + "<shape type=\"sphere\"><bsdf type=\"dielectric\" id=\"glass\"/></shape>");
    const std::uint32_t wall = s.parameter("wall.normal"), glass = s.parameter("glass.normal");
    std::vector<std::string> left;
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"*.normal"}, &left), std::vector<std::uint32_t>{wall});
    EXPECT_EQ(left, std::vector<std::string>{"glass.normal"});
    EXPECT_EQ(s.selectDifferentiable(std::vector<std::string>{"*"}).size(), s.parameters.size() - 3) << "nor are roughness and metallic of smooth glass read";
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

TEST(Mitsuba, IncludedFilesStandWhereTheyAreIncluded) {
    const TempFolder folder;
    save(folder, "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"red\"><rgb name=\"reflectance\" value=\"0.9, 0.1, 0.1\"/></bsdf></scene>", "red.xml");
    save(folder, "<scene version=\"3.0.0\"><include filename=\"red.xml\"/><float name=\"radius\" value=\"2\"/></scene>", "both.xml");
    const Scene s = loadText(folder, "<shape type=\"sphere\"><include filename=\"both.xml\"/></shape><shape type=\"rectangle\"/>");
    ASSERT_EQ(s.materials.size(), 2u);
    EXPECT_EQ(s.materials[s.geometry.triangles.front().material].name, "red");
    EXPECT_NEAR(glm::length(s.geometry.positions[s.geometry.triangles.front().vertices[0]] + glm::vec3(s.center)), 2, 0.01);
    exportScene(s, {}, folder / "out");
    EXPECT_EQ(loadScene(folder / "out/scene.xml").materials.size(), 2u);
    expectRefused(folder, "<shape type=\"sphere\"><include filename=\"none.xml\"/></shape>", "there is no file none.xml");
}

TEST(Mitsuba, IncludedFilesAreFoundBesideTheFileThatIncludesThem) {
    const TempFolder folder;
    fs::create_directories(folder / "parts/inner");
    const auto part = [&](const std::string& name, const std::string& inside) { save(folder, "<scene version=\"3.0.0\">" + inside + "</scene>", name); };
    const auto bsdf = [](const std::string& id) { return "<bsdf type=\"diffuse\" id=\"" + id + "\"/>"; };
    part("parts/materials.xml", "<include filename=\"red.xml\"/><include filename=\"inner/blue.xml\"/><include filename=\"green.xml\"/><include filename=\"../grey.xml\"/>");
    part("parts/red.xml", bsdf("red"));
    part("red.xml", bsdf("wrong"));
    part("parts/inner/blue.xml", bsdf("blue"));
    part("green.xml", bsdf("green")); // beside the scene alone
    part("grey.xml", bsdf("grey"));
    std::string shapes;
    for (const char* id : {"red", "blue", "green", "grey"})
        shapes += "<shape type=\"rectangle\"><ref id=\"" + std::string(id) + "\"/></shape>";
    const Scene s = loadText(folder, "<include filename=\"parts/materials.xml\"/>" + shapes);
    EXPECT_EQ(s.materials.size(), 4u);
    part("parts/materials.xml", "<include filename=\"../../grey.xml\"/>");
    EXPECT_NE(refusal(folder, "<include filename=\"parts/materials.xml\"/>").find("leaves the scene's folder"), std::string::npos);
}

TEST(Mitsuba, NamesMayHaveColons) {
    const TempFolder folder;
    savePng(folder / "a:b.png", 1, 1, 3, {255, 0, 0});
    const auto wall = [](const std::string& file) {
        return "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"wall\"><texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"" + file +
               "\"/></texture></bsdf></shape>";
    };
    const Scene s = loadText(folder, wall("a:b.png"));
    exportScene(s, {}, folder / "out");
    EXPECT_EQ(find(loadScene(folder / "out/scene.xml"), "wall.reflectance").bytes, find(s, "wall.reflectance").bytes);
    for (const char* name : {"https://example.org/a.png", "file:///etc/passwd", "C:/a.png", "/a.png"})
        expectRefused(folder, wall(name), "not a relative path");
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

TEST(Mitsuba, BackslashesAreRefusedByName) {
    const TempFolder folder;
    const std::string message = refusal(folder, "<shape type=\"obj\"><string name=\"filename\" value=\"meshes\\a.obj\"/></shape>"), place = "scene.xml:2: ";
    EXPECT_NE(message.find("use / in place of \\"), std::string::npos) << message;
    EXPECT_EQ(message.find(place), message.rfind(place)) << message;
}

TEST(Mitsuba, Integrators) {
    const TempFolder folder;
    const auto load = [&](const std::string& type, const std::string& inside = "") {
        return loadText(folder, kSquare + "<integrator type=\"" + type + "\">" + inside + "</integrator>");
    };
    const auto depth = [](int n) { return "<integer name=\"max_depth\" value=\"" + std::to_string(n) + "\"/>"; };
    const auto path = [&](int n) { return "<integrator type=\"path\">" + depth(n) + "</integrator>"; };
    for (const char* type : {"path", "volpath", "prb", "bdpt"}) {
        const Scene s = load(type, depth(5));
        EXPECT_EQ(s.maxDepth, 5u) << type;
        EXPECT_FALSE(warned(s, "integrator") || warned(s, "segments")) << type;
    }
    EXPECT_EQ(load("direct").maxDepth, 2u);
    EXPECT_FALSE(warned(load("direct"), "integrator"));
    for (const Scene& s : {load("aov", path(3)), load("moment", "<integrator type=\"aov\">" + path(3) + "</integrator>")}) {
        EXPECT_EQ(s.maxDepth, 3u);
        EXPECT_FALSE(warned(s, "integrator") || warned(s, "segments"));
    }
    const Scene two = load("aov", path(3) + "<integrator type=\"direct\"/>");
    EXPECT_EQ(two.maxDepth, 3u);
    EXPECT_TRUE(warned(two, "the first is rendered"));
    EXPECT_TRUE(warned(load("depth"), "the integrator depth is not supported"));
    EXPECT_TRUE(warned(load("aov"), "the integrator aov is not supported")) << "of no colour";
    EXPECT_TRUE(warned(load("path"), "paths have no limit"));
    const Scene deep = load("path", depth(5000));
    EXPECT_TRUE(warned(deep, "paths may have 5000 segments"));
    EXPECT_FALSE(warned(deep, "no limit"));
    expectRefused(folder, "<integrator type=\"path\" id=\"a\"><ref id=\"a\"/></integrator>" + kSquare, "nested too deeply");
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
        ASSERT_EQ(is.values.size(), was.values.size()) << is.name;
        for (std::size_t k = 0; k < was.values.size(); ++k)
            EXPECT_NEAR(is.values[k], was.values[k], 0.005) << is.name;
    }
    EXPECT_EQ(find(again, "environment.radiance").entries(), 3u) << "a constant stays one";
    EXPECT_EQ(find(again, "plain.bsdf.reflectance").values[0], 0.4f) << "what --define gave is in it";
    EXPECT_TRUE(fs::exists(folder / "out/parameters/shiny.diffuse_reflectance.exr"));
    EXPECT_THROW(exportScene(s, {}, fs::path(s.source).parent_path()), Error);
}

// However the scene names its files, those of the export stand inside its folder.
TEST(Mitsuba, ExportStaysInsideItsFolder) {
    const TempFolder outer;
    savePng(outer / "scene/x.png", 1, 1, 3, {255, 255, 255});
    writeText(outer / "scene/parts/quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
    writeText(outer / "scene/parts/more.xml", "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"included\"><texture type=\"bitmap\" name=\"reflectance\">"
                                              "<string name=\"filename\" value=\"../scene/./x.png\"/></texture></bsdf></scene>");
    const std::string picture = "<texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"../scene/x.png\"/></texture>";
    writeText(outer / "scene/scene.xml", "<scene version=\"3.0.0\"><include filename=\"../scene/parts/more.xml\"/>"
                                         "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"wall\">" + picture + "</bsdf></shape>"
                                         "<shape type=\"obj\"><string name=\"filename\" value=\"parts/../../scene/parts/quad.obj\"/><ref id=\"included\"/></shape>"
                                         "<bsdf type=\"unread\"><string name=\"filename\" value=\"/nowhere/y.png\"/></bsdf></scene>");
    const Scene s = loadScene(outer / "scene/scene.xml");
    fs::create_directories(outer / "elsewhere");
    exportScene(s, {}, outer / "elsewhere/out");
    EXPECT_EQ(std::distance(fs::directory_iterator(outer / "elsewhere"), {}), 1) << "nothing is written beside the folder";
    EXPECT_TRUE(fs::exists(outer / "elsewhere/out/x.png"));
    EXPECT_TRUE(fs::exists(outer / "elsewhere/out/parts/quad.obj"));
    const std::string text = readText(outer / "elsewhere/out/scene.xml");
    EXPECT_EQ(text.find(".."), std::string::npos) << text;
    fs::remove_all(outer / "scene");
    const Scene again = loadScene(outer / "elsewhere/out/scene.xml");
    EXPECT_EQ(again.geometry.positions, s.geometry.positions);
    for (const char* name : {"wall.reflectance", "included.reflectance"})
        EXPECT_EQ(find(again, name).bytes, find(s, name).bytes) << name;
}

// Written by Mitsuba 3's words, whichever the scene has.
TEST(Mitsuba, ExportedTexturesKeepTheirPlace) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    const auto wall = [](const std::string& texture) {
        return "<shape type=\"disk\"><bsdf type=\"diffuse\" id=\"wall\"><texture type=\"bitmap\" name=\"reflectance\">"
               "<string name=\"filename\" value=\"picture.png\"/>" + texture + "</texture></bsdf></shape>";
    };
    const auto written = [&](const std::string& texture) { // and read again
        Scene s = loadText(folder, wall(texture), {}, "0.6.0");
        const std::uint32_t index = s.parameter("wall.reflectance");
        s.parameters[index].materialise();
        std::string text;
        for (const std::vector<std::uint32_t>& changed : {std::vector<std::uint32_t>(), {index}}) {
            exportScene(s, changed, folder / "out");
            const Scene again = loadScene(folder / "out/scene.xml");
            const Parameter &was = s.parameters[index], &is = find(again, "wall.reflectance");
            EXPECT_EQ(is.uvTransform, was.uvTransform) << texture;
            EXPECT_EQ(is.wrapU, was.wrapU) << texture;
            EXPECT_EQ(is.wrapV, was.wrapV) << texture;
            EXPECT_EQ(is.nearest, was.nearest) << texture;
            text = readText(folder / "out/scene.xml");
            EXPECT_EQ(text.find("offset\""), std::string::npos) << "Mitsuba 3 refuses what it does not know: " << text;
        }
        return text;
    };
    const std::string turned = "<transform name=\"toUV\"><rotate angle=\"30\"/><translate x=\"0.1\" y=\"0.7\"/><scale x=\"2\" y=\"3\"/></transform>";
    EXPECT_EQ(written("").find("to_uv"), std::string::npos);
    const std::string old = written("<float name=\"uscale\" value=\"2\"/><float name=\"vscale\" value=\"-3\"/><float name=\"uoffset\" value=\"0.3\"/>"
                                    "<float name=\"voffset\" value=\"0.4\"/>");
    EXPECT_EQ(old.find("scale\""), std::string::npos) << old;
    written(turned + "<float name=\"uoffset\" value=\"0.3\"/>");
    written("<string name=\"filterType\" value=\"nearest\"/><string name=\"wrapModeU\" value=\"mirror\"/><string name=\"wrapModeV\" value=\"mirror\"/>");

    std::string said;
    setLogListener([&](LogLevel, std::string_view, std::string_view message) { said += message; });
    EXPECT_EQ(written("<string name=\"wrapMode\" value=\"clamp\"/>" + turned).find("wrap_mode_"), std::string::npos);
    EXPECT_EQ(said, "");
    written("<string name=\"wrapModeU\" value=\"clamp\"/>");
    written("<string name=\"wrapMode\" value=\"mirror\"/><string name=\"wrapModeV\" value=\"repeat\"/>");
    setLogListener({});
    EXPECT_NE(said.find("wall.reflectance"), std::string::npos) << said;
    EXPECT_NE(said.find("wrap_mode_v"), std::string::npos) << said;
}

TEST(MitsubaExport, ReferencesByAnAliasStay) {
    const TempFolder folder;
    Scene s = loadText(folder, "<bsdf type=\"diffuse\" id=\"a\"/><alias id=\"a\" as=\"b\"/><alias id=\"b\" as=\"c\"/>"
                               "<shape type=\"rectangle\"><ref id=\"c\"/></shape><shape type=\"disk\"><ref id=\"a\"/></shape>");
    const std::uint32_t index = s.parameter("a.reflectance");
    setValues(s.parameters[index], {0.25f, 0.5f, 0.75f});
    exportScene(s, {index}, folder / "out");
    const Scene again = loadScene(folder / "out/scene.xml");
    EXPECT_EQ(again.materials.size(), 1u);
    EXPECT_EQ(find(again, "a.reflectance").values, (std::vector<float>{0.25f, 0.5f, 0.75f}));
}

// A texture that others refer to stays for them where the one who gave it its name has another.
TEST(MitsubaExport, ReferencesToWhatIsReplacedStay) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    const std::string picture = "<texture type=\"bitmap\" name=\"reflectance\" id=\"picture\"><string name=\"filename\" value=\"picture.png\"/></texture>";
    Scene s = loadText(folder, "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"first\">" + picture + "</bsdf></shape>"
                               "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"second\"><ref name=\"reflectance\" id=\"picture\"/></bsdf></shape>");
    const std::uint32_t first = s.parameter("first.reflectance"), second = s.parameter("second.reflectance");
    const std::vector<float> old = cmpg::valuesOf(s.parameters[second]), fresh(6, 1.0f);
    for (const std::uint32_t index : {first, second})
        s.parameters[index].materialise();
    setValues(s.parameters[first], fresh);
    exportScene(s, {first}, folder / "out");
    const Scene again = loadScene(folder / "out/scene.xml");
    EXPECT_EQ(valuesOf(again, "first.reflectance"), fresh);
    EXPECT_EQ(valuesOf(again, "second.reflectance"), old);
    EXPECT_TRUE(again.warnings == s.warnings);
    setValues(s.parameters[second], fresh);
    exportScene(s, {first, second}, folder / "both");
    EXPECT_EQ(valuesOf(loadScene(folder / "both/scene.xml"), "second.reflectance"), fresh);
    EXPECT_FALSE(fs::exists(folder / "both/picture.png")) << "nothing refers to it";
}

// Of the colours of a picture.
std::string wall(const std::string& id, const std::string& picture) {
    return "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"" + id + "\"><texture type=\"bitmap\" name=\"reflectance\"><string name=\"filename\" value=\"" +
           picture + "\"/></texture></bsdf></shape>";
}

TEST(MitsubaExport, CopiesLeaveExactValuesAlone) {
    const TempFolder folder;
    fs::create_directories(folder / "parameters");
    saveExr(folder / "parameters/first.reflectance.exr", 2, 1, "RGB", std::vector<float>(6, 0.25f));
    const std::string picture = "parameters/first.reflectance.exr";
    loadText(folder, wall("first", picture) + wall("second", picture));
    fs::rename(folder / "scene.xml", folder / "room.xml");
    Scene s = loadScene(folder / "room.xml");
    const std::uint32_t first = s.parameter("first.reflectance");
    s.parameters[first].materialise();
    const std::vector<float> values(6, 0.123456f);
    setValues(s.parameters[first], values);
    exportScene(s, {first}, folder / "out");
    EXPECT_EQ(readImage(folder / "out/parameters/first.reflectance.exr").image.values, values);
    EXPECT_EQ(valuesOf(loadScene(folder / "out/scene.xml"), "second.reflectance"), std::vector<float>(6, 0.25f));
    const std::string before = readText(folder / "parameters/first.reflectance.exr");
    EXPECT_THROW(exportScene(s, {first}, folder.path()), Error);
    EXPECT_EQ(readText(folder / "parameters/first.reflectance.exr"), before);
    // Nor an included file.
    save(folder, "<scene version=\"3.0.0\"><include filename=\"scene.xml\"/></scene>", "outer.xml");
    save(folder, "<scene version=\"3.0.0\">" + kSquare + "</scene>");
    EXPECT_THROW(exportScene(loadScene(folder / "outer.xml"), {}, folder.path()), Error);
}

// Textures that are written into the scene's own folder go beside those that are read there.
TEST(MitsubaExport, TexturesOfTheSceneItselfStay) {
    const TempFolder folder;
    fs::create_directories(folder / "textures");
    savePng(folder / "textures/first.reflectance.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    const std::string picture = "textures/first.reflectance.png";
    loadText(folder, wall("first", picture) + wall("second", picture));
    fs::rename(folder / "scene.xml", folder / "room.xml");
    Scene s = loadScene(folder / "room.xml");
    const std::uint32_t first = s.parameter("first.reflectance");
    s.parameters[first].materialise();
    const std::vector<float> old = valuesOf(s, "second.reflectance"), fresh(6, 1.0f);
    setValues(s.parameters[first], fresh);
    exportScene(s, {first}, folder.path());
    const Scene again = loadScene(folder / "scene.xml");
    EXPECT_EQ(valuesOf(again, "first.reflectance"), fresh);
    EXPECT_EQ(valuesOf(again, "second.reflectance"), old);
    EXPECT_EQ(valuesOf(loadScene(folder / "room.xml"), "first.reflectance"), old);
}

// What Mitsuba 3 refuses of version 0.6, in its own words or left out.
TEST(MitsubaExport, OlderWordsBecomeThoseOfMitsuba3) {
    const TempFolder folder;
    savePng(folder / "picture.png", 2, 1, 3, {200, 0, 0, 0, 100, 0});
    const auto texture = [](const char* property, const std::string& inside) {
        return "<texture type=\"bitmap\" name=\"" + std::string(property) + "\"><string name=\"filename\" value=\"picture.png\"/>" + inside + "</texture>";
    };
    const auto text = [](const char* name, const char* value) { return "<string name=\"" + std::string(name) + "\" value=\"" + value + "\"/>"; };
    const auto number = [](const char* name, const char* value) { return "<float name=\"" + std::string(name) + "\" value=\"" + value + "\"/>"; };
    const auto flag = [](const char* name, const char* value) { return "<boolean name=\"" + std::string(name) + "\" value=\"" + value + "\"/>"; };
    const auto square = [](const std::string& inside, const char* type = "rectangle") { return "<shape type=\"" + std::string(type) + "\">" + inside + "</shape>"; };
    const std::string scene =
        "<integrator type=\"bdpt\"><integer name=\"maxDepth\" value=\"5\"/><boolean name=\"lightImage\" value=\"true\"/></integrator>"
        "<sensor type=\"perspective\"><sampler type=\"halton\"><integer name=\"sampleCount\" value=\"16\"/><integer name=\"scramble\" value=\"-1\"/></sampler>"
        "<film type=\"ldrfilm\"><integer name=\"width\" value=\"64\"/><integer name=\"height\" value=\"32\"/>" +
        text("fileFormat", "png") + text("pixelFormat", "luminanceAlpha") + text("tonemapMethod", "gamma") + number("gamma", "-1") + number("exposure", "0") +
        flag("banner", "false") + flag("attachLog", "false") + flag("highQualityEdges", "true") + text("label[10, 10]", "text") + "</film></sensor>" +
        square("<bsdf type=\"diffuse\" id=\"coded\">" + texture("reflectance", text("filterType", "ewa") + number("gamma", "2.2") + number("maxAnisotropy", "8")) + "</bsdf>") +
        square("<bsdf type=\"diffuse\" id=\"raw\">" + texture("reflectance", text("filterType", "trilinear") + number("gamma", "1") + text("wrapModeU", "clamp") + text("wrapModeV", "clamp") + flag("cache", "false")) + "</bsdf>") +
        square("<bsdf type=\"roughconductor\" id=\"metal\">" + number("extEta", "1.33") + text("material", "Au") + "</bsdf>") +
        square("<bsdf type=\"conductor\" id=\"copper\">" + text("extEta", "water") + "</bsdf>", "disk") +
        square("<bsdf type=\"conductor\" id=\"both\">" + text("material", "Al") + "<rgb name=\"k\" value=\"1, 2, 3\"/></bsdf>") +
        square("<bsdf type=\"plastic\" id=\"coated\">" + number("specularSamplingWeight", "0.5") + "</bsdf>" + number("maxSmoothAngle", "30") + flag("collapse", "true"));
    Scene s = loadText(folder, scene, {}, "0.6.0");
    const std::uint32_t alpha = s.parameter("metal.alpha");
    setValues(s.parameters[alpha], {0.25f});
    exportScene(s, {alpha}, folder / "out");
    const std::string out = readText(folder / "out/scene.xml");
    for (const char* unknown : {"bdpt", "light_image", "halton", "scramble", "ldrfilm", "\"png\"", "luminance", "tonemap", "gamma", "exposure", "attach_log", "high_quality", "label", "ewa",
                                "trilinear", "anisotropy", "wrap_mode_", "cache", "ext_eta", "material", "sampling_weight", "max_smooth_angle", "collapse"})
        EXPECT_EQ(out.find(unknown), std::string::npos) << unknown << "\n" << out;
    const Scene again = loadScene(folder / "out/scene.xml");
    EXPECT_EQ(again.maxDepth, 5u);
    EXPECT_EQ(again.cameras[0].size, s.cameras[0].size);
    ASSERT_EQ(again.materials.size(), s.materials.size());
    for (std::size_t i = 0; i < s.materials.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(again.materials[i].eta[c], s.materials[i].eta[c], 1e-6f) << s.materials[i].name;
            EXPECT_NEAR(again.materials[i].k[c], s.materials[i].k[c], 1e-6f) << s.materials[i].name;
        }
    ASSERT_EQ(again.parameters.size(), s.parameters.size());
    for (const Parameter& was : s.parameters) {
        const Parameter& is = find(again, was.name);
        EXPECT_EQ(cmpg::valuesOf(is), cmpg::valuesOf(was)) << was.name;
        EXPECT_EQ(is.wrapU, was.wrapU) << was.name;
        EXPECT_EQ(is.wrapV, was.wrapV) << was.name;
    }
}

// A recovered scene is recovered again: its textures have the names of what is written.
TEST(MitsubaExport, WhatIsWrittenStaysWhereACopyHasItsName) {
    const TempFolder folder;
    fs::create_directories(folder / "textures");
    savePng(folder / "textures/first.reflectance.png", 2, 1, 3, {255, 0, 0, 0, 255, 0});
    const std::string picture = "textures/first.reflectance.png";
    Scene s = loadText(folder, wall("first", picture) + wall("second", picture));
    const std::uint32_t first = s.parameter("first.reflectance");
    s.parameters[first].materialise();
    const std::vector<float> old = valuesOf(s, "second.reflectance"), fresh(6, 1.0f);
    setValues(s.parameters[first], fresh);
    exportScene(s, {first}, folder / "out");
    Scene again = loadScene(folder / "out/scene.xml");
    EXPECT_EQ(valuesOf(again, "first.reflectance"), fresh);
    EXPECT_EQ(valuesOf(again, "second.reflectance"), old);
}

} // namespace
} // namespace cmpg::test
