// What tests of export have in common: a scene with everything in it, changes of its parameters, and a comparison with what loads back.
#pragma once

#include "gltf_writer.h"
#include "scene/image.h"
#include "test_images.h"

#include <cmath>
#include <initializer_list>

namespace cmpg::test {

// A scene with every slot textured in one material, constant in another, and an environment.
struct ExportedScene {
    TempFolder folder;
    GltfWriter w = oneTriangle();

    ExportedScene() {
        std::vector<std::uint8_t> codes;
        for (int i = 0; i < 4 * 4 * 4; ++i) codes.push_back(std::uint8_t(i * 37 + 11));
        savePng(folder / "tex/a b.png", 4, 4, 4, codes);
        w.json["images"] = {{{"uri", "tex/a%20b.png"}}};
        w.json["samplers"] = {{{"wrapS", 33071}}};
        w.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
        const Json info = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0}}}}}}};
        w.json["materials"] = {
            {{"name", "a/b"},
             {"pbrMetallicRoughness",
              {{"baseColorTexture", info}, {"baseColorFactor", {0.5, 1, 1, 0.75}}, {"metallicRoughnessTexture", info}}},
             {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
             {"emissiveTexture", info},
             {"emissiveFactor", {1, 1, 1}},
             {"extensions", {{"KHR_materials_specular", {{"specularTexture", info}}}}}},
            {{"name", "plain"}, {"alphaMode", "MASK"}}};
        w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 1}});
        w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}}); // the default material
        saveExr(folder / "sky.exr", 4, 3, "RGB", std::vector<float>(36, 0.25f));
        w.json["scenes"][0]["extras"]["environment"] = {{"uri", "sky.exr"}, {"intensity", 3}, {"rotation", 1}};
    }
};

// Changes every value of a parameter to something within its range.
inline void change(Parameter& p) {
    p.materialise();
    for (std::size_t i = 0; i < p.values.size(); ++i) {
        const float v = 0.5f + 0.5f * std::sin(float(i) * 1.7f + float(p.name.size()));
        p.values[i] = p.kind == SlotKind::Emission || p.kind == SlotKind::Radiance ? 20 * v : v;
    }
    if (p.kind == SlotKind::Normal)
        for (std::size_t i = 0; i < p.values.size(); i += 3) {
            const glm::vec3 n = glm::normalize(glm::vec3(p.values[i] - 0.5f, p.values[i + 1] - 0.5f, 1));
            for (int c = 0; c < 3; ++c) p.values[i + std::size_t(c)] = n[c];
        }
}

// Half a code of 8 bits in the encoding of the slot; constants and the environment are exact up to float rounding.
inline float tolerance(const Parameter& p, float value, float largest) {
    if (!p.textured || p.kind == SlotKind::Radiance) return 1e-6f * largest;
    if (p.kind == SlotKind::Normal) return 1.01f / 255;
    if (p.channels == 1) return 0.505f / 255;
    const float code = srgbEncode(value / largest), half = 0.505f / 255;
    return largest * (srgbDecode(std::min(code + half, 1.0f + half)) - srgbDecode(std::max(code - half, 0.0f)));
}

inline void expectSame(const Scene& a, const Scene& b) {
    ASSERT_EQ(a.parameters.size(), b.parameters.size());
    for (const Parameter& pa : a.parameters) {
        const Parameter& pb = find(b, pa.name);
        SCOPED_TRACE(pa.name);
        EXPECT_EQ(pa.textured, pb.textured);
        EXPECT_EQ(pa.wrapU, pb.wrapU);
        EXPECT_EQ(pa.uvTransform, pb.uvTransform);
        const std::vector<float> va = valuesOf(a, pa.name), vb = valuesOf(b, pa.name);
        ASSERT_EQ(va.size(), vb.size());
        const bool bright = pa.kind == SlotKind::Emission || pa.kind == SlotKind::Radiance;
        const float largest = bright ? std::max(*std::max_element(va.begin(), va.end()), 1e-9f) : 1.0f;
        for (std::size_t i = 0; i < va.size(); ++i) ASSERT_NEAR(va[i], vb[i], tolerance(pa, va[i], largest)) << i;
    }
}

// Changes the named parameters.
inline std::vector<std::uint32_t> changeNamed(Scene& s, std::initializer_list<const char*> names) {
    std::vector<std::uint32_t> indices;
    for (const char* name : names) {
        indices.push_back(s.parameter(name));
        change(s.parameters[indices.back()]);
    }
    return indices;
}

// Writes the scene with what was changed, and expects that the same loads back.
inline Scene loadedBack(const Scene& s, const std::vector<std::uint32_t>& changed) {
    const TempFolder out;
    exportScene(s, changed, out.path());
    Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    return back;
}

} // namespace cmpg::test
