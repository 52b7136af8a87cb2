// Small glTF files made by the tests, in a folder of their own.
#pragma once

#include "base/error.h"
#include "scene/scene_file.h"
#include "support/temp_folder.h"

#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg::test {

using Json = nlohmann::json;
namespace fs = std::filesystem;

inline void writeBytes(const fs::path& file, const void* data, std::size_t size) {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary).write(static_cast<const char*>(data), std::streamsize(size));
}
inline void writeText(const fs::path& file, const std::string& text) { writeBytes(file, text.data(), text.size()); }
inline std::string readText(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline const char* typeName(std::size_t components) {
    constexpr const char* kNames[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    return kNames[components];
}

// A glTF under construction: edit `json` freely, add data, then write.
struct GltfWriter {
    Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", {0}}}}}};
    std::string data; // of buffers[0]

    template <class T> std::size_t view(const std::vector<T>& values) {
        while (data.size() % 4) data += '\0';
        const std::size_t offset = data.size();
        data.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        json["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
        return json["bufferViews"].size() - 1;
    }
    template <class T> std::size_t accessor(const std::vector<T>& values, std::size_t components, int type, bool normalized = false) {
        json["accessors"].push_back({{"bufferView", view(values)},
                                     {"componentType", type},
                                     {"count", values.size() / components},
                                     {"type", typeName(components)},
                                     {"normalized", normalized}});
        return json["accessors"].size() - 1;
    }
    std::size_t floats(const std::vector<float>& values, std::size_t components) { return accessor(values, components, 5126); }
    std::size_t indices(const std::vector<std::uint16_t>& values) { return accessor(values, 1, 5123); }

    void finish(bool embedded) {
        if (data.empty()) return;
        json["buffers"] = {{{"byteLength", data.size()}}};
        if (!embedded) json["buffers"][0]["uri"] = "data.bin";
    }
    fs::path write(const TempFolder& folder, const std::string& name = "scene.gltf") {
        finish(false);
        if (!data.empty()) writeText(folder / "data.bin", data);
        writeText(folder / name, json.dump(1));
        return folder / name;
    }
    std::string glb() {
        finish(true);
        std::string text = json.dump(), binary = data;
        while (text.size() % 4) text += ' ';
        while (binary.size() % 4) binary += '\0';
        const auto word = [](std::size_t v) {
            const auto w = std::uint32_t(v);
            return std::string(reinterpret_cast<const char*>(&w), 4);
        };
        return "glTF" + word(2) + word(12 + 8 + text.size() + 8 + binary.size()) + word(text.size()) + "JSON" + text + word(binary.size()) +
               std::string("BIN\0", 4) + binary;
    }
};

// One triangle (0,0,0) (1,0,0) (0,1,0), counter-clockwise seen from +Z, with one material, node and mesh.
inline GltfWriter oneTriangle() {
    GltfWriter w;
    const std::size_t positions = w.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3), uv = w.floats({0, 0, 1, 0, 0, 1}, 2);
    w.json["nodes"] = {{{"mesh", 0}}};
    w.json["materials"] = {{{"name", "wall"}}};
    w.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uv}}}, {"material", 0}}}}}};
    return w;
}
inline Json& primitive(GltfWriter& w) { return w.json["meshes"][0]["primitives"][0]; }

inline const Parameter& find(const Scene& scene, const std::string& name) { return scene.parameters[scene.parameter(name)]; }
inline std::vector<float> valuesOf(const Scene& scene, const std::string& name) {
    Parameter p = find(scene, name);
    p.materialise();
    return p.values;
}
inline bool warned(const Scene& scene, const std::string& part) {
    for (const std::string& w : scene.warnings)
        if (w.find(part) != std::string::npos) return true;
    return false;
}

inline void expectVec(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-6f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

} // namespace cmpg::test
