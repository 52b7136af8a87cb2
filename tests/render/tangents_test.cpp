// Tangents that are made for files without, as kernels use them.
#include "support/render_fixture.h"
#include "support/temp_folder.h"

#include <fstream>
#include <nlohmann/json.hpp>

namespace cmpg::test {
namespace {

// The bundled scene whose flat panel with a normal map has normals.
Scene panelWithNormals() {
    namespace fs = std::filesystem;
    const TempFolder temporary;
    const std::string folder = temporary.path();
    fs::copy(fs::path(CMPG_SOURCE_DIR "/scenes/materials"), folder, fs::copy_options::recursive);
    nlohmann::json gltf = nlohmann::json::parse(std::ifstream(folder + "/scene.gltf"));
    const Scene plain = bundledScene("materials");
    for (nlohmann::json& mesh : gltf["meshes"]) {
        nlohmann::json& primitive = mesh["primitives"][0];
        const std::size_t material = primitive["material"];
        if (!plain.materials[material].hasNormalMap)
            continue;
        const Geometry& g = plain.geometry;
        const Triangle& t = *std::find_if(g.triangles.begin(), g.triangles.end(), [&](const Triangle& triangle) { return triangle.material == material; });
        const glm::vec3 a = g.positions[t.vertices[0]];
        const std::vector<glm::vec3> normals(4, glm::normalize(glm::cross(g.positions[t.vertices[1]] - a, g.positions[t.vertices[2]] - a)));
        std::ofstream(folder + "/normals.bin", std::ios::binary).write(reinterpret_cast<const char*>(normals.data()), 48);
        primitive["attributes"]["NORMAL"] = gltf["accessors"].size();
        gltf["accessors"].push_back({{"bufferView", gltf["bufferViews"].size()}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
        gltf["bufferViews"].push_back({{"buffer", gltf["buffers"].size()}, {"byteOffset", 0}, {"byteLength", 48}});
        gltf["buffers"].push_back({{"uri", "normals.bin"}, {"byteLength", 48}});
    }
    std::ofstream(folder + "/scene.gltf") << gltf;
    return loadScene(folder + "/scene.gltf");
}

// On a flat surface they are those that kernels derive from each triangle.
TEST(MadeTangents, AreThoseOfTheTrianglesWhereThoseAreFlat) {
    Scene scene = panelWithNormals();
    ASSERT_FALSE(scene.geometry.tangents.empty());
    const Image derived = smallImage(bundledScene("materials")), made = smallImage(scene);
    EXPECT_LT(relativeDifference(made, derived), 1e-5);
    for (glm::vec4& t : scene.geometry.tangents) t.w = -t.w;
    EXPECT_GT(relativeDifference(smallImage(scene), derived), 1e-3) << "bitangents matter";
}

} // namespace
} // namespace cmpg::test
