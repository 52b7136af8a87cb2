// glTF and .glb scenes, with what the renderer makes of them on the host.
#include "fuzz.h"
#include "scene/bvh.h"
#include "scene/features.h"
#include "scene/image_decode.h"
#include "scene/light_distribution.h"
#include "scene/scene_file.h"
#include "support/scene_mutation.h"

#include <cmath>
#include <numeric>

using namespace cmpg;
namespace fs = std::filesystem;

namespace {

// Larger ones are refused, so that what a small file makes of itself shows.
const LoadOptions kLimits = {.maxTextureSize = 512, .maxTriangles = 1 << 14, .maxTextureBytes = 1 << 24};

// The folder of the scene, with what it may name beside itself.
class SceneFolder {
  public:
    SceneFolder() {
        std::string pattern = (fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path().string()) + "/cmpg-fuzz-XXXXXX";
        path_ = ::mkdtemp(pattern.data());
        writeFile(path_ / "image.png", encodePng(Image(2, 2, 3, 0.5f)));
        writeFile(path_ / "sky.exr", encodeExr(Image(4, 2, 3, 0.5f)));
        writeFile(path_ / "data.bin", Bytes(256, 0x3f));
    }
    ~SceneFolder() { fs::remove_all(path_); }
    SceneFolder(const SceneFolder&) = delete;

    fs::path holding(fuzz::Input scene) const {
        const fs::path file = path_ / "scene.gltf";
        std::FILE* const out = std::fopen(file.c_str(), "wb");
        const bool written = out && std::fwrite(scene.data(), 1, scene.size(), out) == scene.size() && std::fclose(out) == 0;
        fuzz::require(written, "the input can be written");
        return file;
    }

  private:
    fs::path path_;
};

// What later code takes for granted.
void requireSound(const Scene& scene) {
    const Geometry& g = scene.geometry;
    for (const glm::vec3& p : g.positions)
        fuzz::require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z), "positions are finite");
    for (const std::size_t size : {g.normals.size(), g.uv0.size(), g.uv1.size(), g.tangents.size(), g.colors.size()})
        fuzz::require(size == 0 || size == g.positions.size(), "attributes belong to all vertices");
    for (const Triangle& t : g.triangles) {
        fuzz::require(t.material < scene.materials.size(), "triangles have materials");
        for (const std::uint32_t v : t.vertices)
            fuzz::require(v < g.positions.size(), "triangles have vertices");
    }
    for (const Parameter& p : scene.parameters) {
        fuzz::require(p.entries() == std::max(p.values.size(), p.bytes.size()), "parameters have all their entries");
        for (const float v : p.values)
            fuzz::require(std::isfinite(v), "parameters are finite");
    }
    fuzz::require(!scene.cameras.empty(), "there is a camera");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const SceneFolder folder;
    const fs::path file = folder.holding({data, size});
    fuzz::accepts({ErrorKind::Input}, [&] {
        const Scene scene = loadScene(file, kLimits);
        requireSound(scene);
        std::vector<std::uint32_t> all(scene.parameters.size());
        std::iota(all.begin(), all.end(), 0u);
        analyse(scene, {.differentiable = all});
        geometryHash(scene);
        const Bvh bvh = buildBvh(scene.geometry, 1);
        fuzz::require(bvh.order.size() == scene.geometry.triangles.size(), "every triangle has its place in the hierarchy");
        buildLights(scene, bvh, all);
    });
    return 0;
}

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

// Bytes of any file; of a .gltf mostly values of its JSON instead.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
    const auto brackets = std::count(data, data + size, '[') + std::count(data, data + size, '{');
    if (seed % 4 == 0 || brackets > 1000) // its depth is a recursion's
        return LLVMFuzzerMutate(data, size, most);
    nlohmann::json json = nlohmann::json::parse(data, data + size, nullptr, false);
    if (!json.is_object())
        return LLVMFuzzerMutate(data, size, most);
    test::SceneMutation mutation(seed);
    for (unsigned i = 0; i <= seed / 4 % 3; ++i)
        mutation.apply(json);
    const std::string text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (text.size() > most)
        return LLVMFuzzerMutate(data, size, most);
    std::copy(text.begin(), text.end(), data);
    return text.size();
}
