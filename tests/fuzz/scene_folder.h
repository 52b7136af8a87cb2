// What the targets of scene files share: a folder for the scene, what it may name beside itself, and what later code takes for granted.
#pragma once

#include "fuzz.h"
#include "scene/bvh.h"
#include "scene/features.h"
#include "scene/image_decode.h"
#include "scene/light_distribution.h"
#include "scene/scene_file.h"
#include "support/temp_folder.h"

#include <cmath>

namespace cmpg::fuzz {

namespace fs = std::filesystem;

// Larger ones are refused, so that what a small file makes of itself shows.
inline const LoadOptions kLimits = {.maxTextureSize = 512, .maxTriangles = 1 << 14, .maxTextureBytes = 1 << 24};

// The folder of the scene, with what it may name beside itself.
class SceneFolder {
  public:
    explicit SceneFolder(std::string name) : name_(std::move(name)), folder_(fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path()) {
        writeFile(folder_ / "image.png", encodePng(Image(2, 2, 3, 0.5f)));
        writeFile(folder_ / "sky.exr", encodeExr(Image(4, 2, 3, 0.5f)));
        writeFile(folder_ / "data.bin", Bytes(256, 0x3f));
        const std::string mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 1 2 4\n";
        writeFile(folder_ / "mesh.obj", {reinterpret_cast<const std::uint8_t*>(mesh.data()), mesh.size()});
        const std::string ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                                "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 0 1 0 3 0 1 2\n";
        writeFile(folder_ / "mesh.ply", {reinterpret_cast<const std::uint8_t*>(ply.data()), ply.size()});
        const std::string part = "<scene version=\"3.0.0\"><bsdf type=\"diffuse\" id=\"included\"/></scene>";
        writeFile(folder_ / "part.xml", {reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
    }

    fs::path holding(Input scene) const {
        const fs::path file = folder_ / name_;
        std::FILE* const out = std::fopen(file.c_str(), "wb");
        const bool written = out && std::fwrite(scene.data(), 1, scene.size(), out) == scene.size() && std::fclose(out) == 0;
        require(written, "the input can be written");
        return file;
    }

  private:
    std::string name_;
    test::TempFolder folder_;
};

// What later code takes for granted.
inline void requireSound(const Scene& scene) {
    const Geometry& g = scene.geometry;
    for (const glm::vec3& p : g.positions)
        require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    for (const std::size_t size : {g.normals.size(), g.uv0.size(), g.uv1.size(), g.tangents.size(), g.colors.size()})
        require(size == 0 || size == g.positions.size(), "attributes belong to all vertices");
    for (const Triangle& t : g.triangles) {
        require(t.material < scene.materials.size(), "triangles have materials");
        for (const std::uint32_t v : t.vertices)
            require(v < g.positions.size(), "triangles have vertices");
    }
    for (const Parameter& p : scene.parameters) {
        require(p.entries() == std::max(p.values.size(), p.bytes.size()), "parameters have all their entries");
        for (const float v : p.values)
            require(std::isfinite(v), "parameters are finite");
    }
    require(!scene.cameras.empty(), "there is a camera");
}

// Loads it, and does what the host does with a scene.
inline void useScene(const fs::path& file) {
    const Scene scene = loadScene(file, kLimits);
    requireSound(scene);
    std::vector<bool> fixed(scene.parameters.size(), false);
    for (const Material& m : scene.materials)
        if (!hasNormalDerivative(m))
            fixed[m.parameters[std::size_t(SlotKind::Normal)]] = true;
    std::vector<std::uint32_t> all;
    for (std::uint32_t p = 0; p < fixed.size(); ++p)
        if (!fixed[p])
            all.push_back(p);
    analyse(scene, {.differentiable = all});
    geometryHash(scene);
    const Bvh bvh = buildBvh(scene.geometry, 1);
    require(bvh.order.size() == scene.geometry.triangles.size(), "every triangle has its place in the hierarchy");
    buildLights(scene, bvh, all);
}

} // namespace cmpg::fuzz
