// BSDFs and area lights of Mitsuba scenes.
#include "mitsuba_scene.h"
#include "scene/image.h"
#include "scene/parameter_values.h"
#include "scene/scene_file.h"
#include "test_images.h"

#include <set>

namespace cmpg::test {
namespace {

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

TEST(Mitsuba, MetalsWithoutANameAreMirrorsOrOfOldCopper) {
    const TempFolder folder;
    for (const char* type : {"conductor", "roughconductor"}) {
        const auto shape = [&](const std::string& inside) { return "<shape type=\"disk\"><bsdf type=\"" + std::string(type) + "\">" + inside + "</bsdf></shape>"; };
        for (const char* version : {"3.0.0", "2.1.0"}) {
            const Material m = loadText(folder, shape(""), {}, version).materials[0];
            EXPECT_EQ(m.eta, glm::vec3(0)) << version << ": reflects all";
            EXPECT_EQ(m.k, glm::vec3(1)) << version;
        }
        const Material copper = loadText(folder, shape("<string name=\"material\" value=\"Cu\"/>")).materials[0];
        const Scene old = loadText(folder, shape(""), {}, "0.6.0");
        EXPECT_EQ(old.materials[0].eta, copper.eta);
        EXPECT_EQ(old.materials[0].k, copper.k);
        exportScene(old, {}, folder / type);
        EXPECT_EQ(loadScene(folder / type / "scene.xml").materials[0].eta, copper.eta) << "as a file of version 3";
        EXPECT_EQ(loadText(folder, shape("<rgb name=\"eta\" value=\"0.5\"/>"), {}, "0.6.0").materials[0].k, glm::vec3(1));
    }
}

TEST(Mitsuba, NullSurfacesLetLightThroughAndMayEmit) {
    const TempFolder folder;
    const std::string null = "<bsdf type=\"null\"/>", emitter = "<emitter type=\"area\"><rgb name=\"radiance\" value=\"3\"/></emitter>";
    const Scene s = loadText(folder, kSquare + "<shape type=\"disk\">" + null + "</shape><shape type=\"rectangle\" id=\"lamp\">" + null + emitter + "</shape>");
    ASSERT_EQ(s.geometry.triangles.size(), 4u) << "the disk is not there";
    const Material& m = s.materials[s.geometry.triangles.back().material];
    EXPECT_EQ(m.model, SurfaceModel::ThinDielectric);
    EXPECT_EQ(m.ior, 1);
    EXPECT_FALSE(m.oneSided);
    EXPECT_EQ(s.parameters[m.parameters[std::size_t(SlotKind::BaseColor)]].values, std::vector<float>(3, 1.0f));
    EXPECT_EQ(find(s, "lamp.emitter.radiance").values, std::vector<float>(3, 3.0f));
}

TEST(Mitsuba, EncodedColoursAreDecoded) {
    const TempFolder folder;
    const auto shape = [](const std::string& value) { return "<shape type=\"disk\"><bsdf type=\"diffuse\" id=\"wall\"><srgb name=\"reflectance\" value=\"" + value + "\"/></bsdf></shape>"; };
    const auto color = [&](const std::string& value) { return find(loadText(folder, shape(value), {}, "0.6.0"), "wall.reflectance").values; };
    EXPECT_EQ(color("0.5, 0.02 1"), (std::vector<float>{srgbDecode(0.5f), 0.02f / 12.92f, 1}));
    EXPECT_EQ(color("0.5"), std::vector<float>(3, srgbDecode(0.5f)));
    EXPECT_EQ(color("#8040FF"), (std::vector<float>{srgbDecode(128 / 255.0f), srgbDecode(64 / 255.0f), 1}));
    const Scene s = loadText(folder, shape("#8040ff"));
    exportScene(s, {}, folder / "out");
    EXPECT_EQ(readText(folder / "out/scene.xml").find("srgb"), std::string::npos) << "Mitsuba 3 does not read it";
    EXPECT_EQ(find(loadScene(folder / "out/scene.xml"), "wall.reflectance").values, find(s, "wall.reflectance").values);
    for (const char* value : {"#8040f", "#8040ffa", "#80-0ff", "0 #8040ff", "#"})
        expectRefused(folder, shape(value), "write #rrggbb");
    expectRefused(folder, shape("0.1 0.2"), "one number or three");
}

// What stock Mitsuba 3.9.1 makes of them in its rgb mode.
TEST(Mitsuba, SpectraThatAreColours) {
    const TempFolder folder;
    const auto lamp = [](const std::string& type, const std::string& inside) {
        return "<shape type=\"disk\" id=\"lamp\"><emitter type=\"area\"><spectrum name=\"radiance\" type=\"" + type + "\">" + inside + "</spectrum></emitter></shape>";
    };
    const auto radiance = [&](const std::string& type, const std::string& inside) { return find(loadText(folder, lamp(type, inside)), "lamp.emitter.radiance").values; };
    const std::string color = "<rgb name=\"color\" value=\"1, 2, 3\"/>", scale = "<float name=\"scale\" value=\"3\"/>";
    EXPECT_EQ(radiance("uniform", "<float name=\"value\" value=\"0.75\"/>"), std::vector<float>(3, 0.75f));
    EXPECT_EQ(radiance("d65", ""), std::vector<float>(3, 1.0f));
    EXPECT_EQ(radiance("d65", scale), std::vector<float>(3, 3.0f));
    EXPECT_EQ(radiance("d65", color + scale), (std::vector<float>{3, 6, 9}));
    EXPECT_EQ(radiance("srgb", color), (std::vector<float>{1, 2, 3}));
    const Scene shared = loadText(folder, "<spectrum type=\"d65\" id=\"white\">" + scale + "</spectrum><emitter type=\"point\"><ref name=\"intensity\" id=\"white\"/></emitter>" + kSquare);
    EXPECT_EQ(shared.lights.at(0).intensity, glm::vec3(3));
    expectRefused(folder, lamp("blackbody", "<float name=\"temperature\" value=\"5000\"/>"), "the spectrum blackbody is not supported");
    expectRefused(folder, lamp("uniform", ""), "needs a value");
    expectRefused(folder, lamp("srgb", ""), "needs a color");
    expectRefused(folder, lamp("d65", "<float name=\"temperature\" value=\"5000\"/>"), "no property temperature");
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
    EXPECT_EQ(load("<rgb name=\"opacity\" value=\"0.25\"/>").materials[0].alphaFactor, 0.25f);
    EXPECT_EQ(load("<rgb name=\"opacity\" value=\"1, 0.5, 0\"/>").materials[0].alphaFactor, 0.5f) << "the mean";
    EXPECT_FALSE(load("<float name=\"opacity\" value=\"1\"/>").materials[0].alphaMask);
    const auto texture = [](const std::string& more) {
        return "<texture type=\"bitmap\" name=\"opacity\"><string name=\"filename\" value=\"opacity.png\"/>" + more + "</texture>";
    };
    const Scene encoded = load(texture("")), raw = load(texture("<boolean name=\"raw\" value=\"true\"/>"));
    EXPECT_TRUE(encoded.materials[0].coverage);
    EXPECT_EQ(encoded.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 128})) << "sRGB";
    EXPECT_EQ(raw.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 188}));
}

// Shapes without an id are told apart by their lines, of which two included files have the same.
TEST(Mitsuba, LampsHaveNamesOfTheirOwn) {
    const TempFolder folder;
    const auto lamp = [&](const std::string& name, const std::string& radiance, const std::string& id) {
        save(folder, "<scene version=\"3.0.0\">\n<shape type=\"rectangle\"><emitter type=\"area\"" + id + "><rgb name=\"radiance\" value=\"" + radiance + "\"/></emitter></shape>\n</scene>\n", name);
        return "<include filename=\"" + name + "\"/>";
    };
    Scene s = loadText(folder, lamp("a.xml", "3, 2, 1", "") + lamp("b.xml", "1, 4, 9", "") + lamp("c.xml", "5, 6, 7", ""));
    EXPECT_EQ(s.select("*radiance").size(), 3u);
    std::set<std::string> names;
    for (const Parameter& p : s.parameters)
        EXPECT_TRUE(names.insert(p.name).second) << p.name;
    EXPECT_EQ(s.parameters[s.parameter("shape2.emitter.radiance")].values, (std::vector<float>{3, 2, 1}));
    const std::uint32_t second = s.parameter("shape2#2.emitter.radiance");
    EXPECT_EQ(s.parameters[second].values, (std::vector<float>{1, 4, 9}));
    // What is written of one is not the other's.
    setValues(s.parameters[second], {7, 8, 9});
    exportScene(s, {second}, folder / "out");
    const Scene again = loadScene(folder / "out/scene.xml");
    std::vector<float> all;
    for (const std::uint32_t p : again.select("*radiance"))
        all.insert(all.end(), again.parameters[p].values.begin(), again.parameters[p].values.end());
    EXPECT_EQ(all, (std::vector<float>{3, 2, 1, 7, 8, 9, 5, 6, 7}));
}

} // namespace
} // namespace cmpg::test
