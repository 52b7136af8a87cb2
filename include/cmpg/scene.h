// A scene: what a file holds, with parameters that can be read, changed and differentiated.
#pragma once

#include <cmpg/error.h>
#include <cmpg/filter.h>
#include <cmpg/namespace.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace cmpg::v1 {

struct CameraInfo {
    std::string name = {};
    std::optional<float> aspect = {}; // width / height where nothing else is asked for, above 0; none: as the file says, if it does
    // From the camera to the world, column by column: the directions to its right, above it and behind it, then its place. It looks against the third.
    std::array<float, 16> toWorld = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    bool orthographic = false;
    float yfov = 0.8f; // perspective: angle of the picture's height in radians, above 0 and below pi
    float ymag = 1;    // orthographic: half the picture's height in the scene's units, above 0
};

// The box around all triangles, in the coordinates of cameras and points.
struct SceneBox {
    std::array<float, 3> lower = {}, upper = {};
    std::array<double, 3> center = {}; // was subtracted from the file's own coordinates, where the scene is far from their origin
};

// What a ray of a camera hits first.
struct SurfacePoint {
    std::array<float, 3> position = {}, normal = {}; // the triangle's normal, towards the camera
    float distance = 0;                              // along the ray
    std::string material = {};
};

// A slot of a material, or the radiance of the environment. Its values are a texture of height x width x channels, row-major, row 0 on top,
// linear; a constant is a texture of one texel.
struct ParameterInfo {
    std::string name = {}; // "<material>.<slot>" or "environment.radiance"
    std::string slot = {}; // "baseColor", "roughness", "metallic", "specular", "emission", "normal", "clearcoat", "clearcoatRoughness", "anisotropy", "sheenRoughness", "sheenColor", "weight" or "radiance"
    int height = 1, width = 1, channels = 3;
    float lowest = 0, highest = 1; // range of the values; `highest` may be infinite

    bool textured = false; // the file has an image for it, or resize() made one; else a constant

    std::size_t entries() const { return std::size_t(height) * std::size_t(width) * std::size_t(channels); }
};

// What a scene may be given beside its file.
struct SceneOptions {
    std::filesystem::path environment = {};  // latitude-longitude picture of the surroundings, in place of the scene's own or of none
    float environmentRotation = 0;           // degrees about +y
    std::map<std::string, std::string> define = {}; // values of the variables of a Mitsuba scene
    std::optional<ReconstructionFilter> filter = {}; // of all cameras, in place of the scene's own
};

// Owns the current values. Renderers follow them, a recovery begins at them and keeps its own. Safe to use from several threads.
class Scene {
  public:
    // Reads glTF (.gltf, .glb) or Mitsuba XML (.xml). Error(Input) on what is missing, malformed or too large.
    static Scene load(const std::filesystem::path& file, const SceneOptions& options = {});
    static std::vector<std::string> extensions(); // of such files, with the dot, lower case
    Scene copy() const; // with values of its own

    std::string source() const;                // the file it came from
    std::vector<std::string> warnings() const; // what the file has that is not rendered, and the like
    std::uint32_t maxDepth() const;            // segments of a path that the file asks for, else 8

    std::vector<CameraInfo> cameras() const; // never empty
    // Width and height of an image in pixels, as passes have them: 0 follows from the other by the camera's aspect ratio, both 0: a Mitsuba film's size,
    // else 512 wide. Error(Usage) on an unknown camera.
    std::pair<int, int> imageSize(const std::string& camera = {}, int width = 0, int height = 0) const;
    SceneBox box() const;
    // The surface at a place of a picture of width x height pixels, 0 as in imageSize(); (0,0) is the top left corner of the top left pixel. None where there is
    // no surface. Of the camera's name: see PassOptions::from. Tries every triangle, on the host: some milliseconds for a million.
    std::optional<SurfacePoint> pick(const CameraInfo& camera, int width, int height, float x, float y) const;

    std::vector<ParameterInfo> parameters() const;
    ParameterInfo parameter(const std::string& name) const; // Error(Usage), with the nearest names, where there is none
    // Names of the parameters that a glob selects (* any characters, ? one), in order. Error(Usage) where there is none.
    std::vector<std::string> select(const std::string& glob) const;

    std::vector<float> values(const std::string& name, ParameterInfo* info = nullptr) const; // entries() of them; `info`: what the parameter is in that moment
    // `values`: entries() of them, or one per channel, or one for all. Error(Usage) on another number of values, or values out of range.
    void set(const std::string& name, std::span<const float> values);

    // Gives a parameter a texture of this size, from 1 to 8192 texels along each edge: of a constant, or resampled, so that the surface looks the same as far as
    // texels allow. Error(Usage) where there is no place for one: meshes without texture coordinates, normals without a normal map, anisotropy, an
    // environment of one colour.
    void resize(const std::string& name, int width, int height);

    // Writes the scene in the format of its file, as `folder`/scene.gltf or scene.xml, with the values that set() or a recovery changed (textures as 8-bit PNG), and
    // the exact ones as `folder`/parameters/<name>.exr. Returns the scene's file. Error(Output) where that fails.
    std::filesystem::path exportTo(const std::filesystem::path& folder) const;
    // With the values of these parameters alone. Error(Usage) on unknown ones.
    std::filesystem::path exportTo(const std::filesystem::path& folder, std::span<const std::string> parameters) const;

    struct State;
    const std::shared_ptr<State>& state() const { return state_; }

  private:
    explicit Scene(std::shared_ptr<State> state) : state_(std::move(state)) {}
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
