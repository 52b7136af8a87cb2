// Puts a scene together for the importers: names, clamps, limits and warnings are the same whatever the file.
#pragma once

#include "scene/geometry_builder.h"
#include "scene/image_decode.h"
#include "scene/scene_file.h"

#include <functional>
#include <map>
#include <optional>
#include <set>

namespace cmpg {

// Names given so far, and the last number of their likes.
using UniqueNames = std::map<std::string, std::uint32_t>;

// `name` without control characters, made unique by #2, #3 ...
std::string uniqueName(std::string name, UniqueNames& taken);

// How surface points find texels.
struct TextureAddress {
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    bool nearest = false;
    std::uint32_t texcoord = 0;
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0};
    bool operator==(const TextureAddress&) const = default;

    // Parameter, AlphaTexture or DirectionTexture.
    template <class Target> void apply(Target& target) const {
        target.wrapU = wrapU;
        target.wrapV = wrapV;
        target.nearest = nearest;
        target.texcoord = texcoord;
        target.uvTransform = uvTransform;
    }
};

// The channels of an image that make a slot, and how its codes become values.
struct SlotTexels {
    std::array<std::uint32_t, 3> channels{0, 1, 2}; // red 0 ... alpha 3
    bool srgb = false;                              // codes are sRGB-encoded, but for images that are linear anyway
    glm::vec3 scale{1}, bias{0};
};

// Of emission and radiance: leaves room for the products of a float texture and the sums of a path.
constexpr float kBrightest = 1e30f;

class SceneBuilder {
  public:
    // `name` of the file stands in messages.
    SceneBuilder(std::string name, LoadOptions loadOptions) : options(std::move(loadOptions)), name_(std::move(name)) {}

    Scene scene;
    const LoadOptions options;
    GeometryBuilder geometry;
    std::set<std::string> ignored; // what the file has and we do not render: named in one warning

    const std::string& name() const { return name_; }
    void warn(const std::string& text); // once
    // Fails beyond LoadOptions::maxTextureBytes.
    void addTextureBytes(std::uint64_t bytes, const std::string& parameter);
    // What images of textures may be at most.
    ImageLimits imageLimits() const { return {.maxEdge = options.maxTextureSize, .maxPixels = options.maxTextureSize * options.maxTextureSize}; }

    // A constant parameter as the `kind` of a material, clamped to its range; texels may replace it. Valid until the next. `name`: of the slot
    // in the scene's own format, where that is another.
    Parameter& addSlot(Material& material, SlotKind kind, std::uint32_t channels, glm::vec3 constant, const std::string& name = {});
    void fillTexels(Parameter& parameter, const RawImage& image, const TextureAddress& address, const SlotTexels& texels);
    void clampToRange(Parameter& parameter);
    // Nothing where the image has no alpha.
    void addAlphaTexture(Material& material, const RawImage& image, const TextureAddress& address);

    // Red and green, from [0, 1] to [-1, 1], turned counter-clockwise by so many radians: the material's direction of anisotropy.
    void addDirectionTexture(Material& material, const RawImage& image, const TextureAddress& address, double rotation);

    // A normal map, x and y times `scale`: the normals of the material's clear coat.
    void addClearcoatNormals(Material& material, const RawImage& image, const TextureAddress& address, float scale);

    // Warns of textures of a material on a mesh that lacks the set of texture coordinates they are looked up by: all of it then shows what is at (0, 0).
    void checkTexcoords(std::uint32_t material, bool uv0, bool uv1);

    // Latitude-longitude, of a single pixel a constant; adds its parameter. False: a value times the intensity is too large a number.
    bool setEnvironment(const RawImage& image, float intensity, float rotation);

    // A frame's axes made orthonormal, with its origin moved as the scene was: scale and shear do not bend a camera, a mirrored frame mirrors
    // it. Nothing where it is singular. After geometry.finish().
    std::optional<glm::mat4> cameraFrame(const glm::dmat4& toWorld) const;
    // Frames the bounding box where there is no camera.
    void ensureCamera();
    // The environment of the options in place of the scene's own.
    void applyOptions();
    // Warnings about what was left out, and what is missing. `skipped`: what the importer left out, beside degenerate triangles.
    void summarise(const std::vector<std::pair<std::uint64_t, const char*>>& skipped = {});

  private:
    // Of each texel, what `direction` makes of its code, from [0, 1] to [-1, 1]. Returns the place among the scene's.
    std::uint32_t addDirections(const Material& material, const RawImage& image, const TextureAddress& address, const std::function<glm::dvec2(const glm::dvec3&)>& direction);

    std::string name_;
    std::uint64_t textureBytes_ = 0; // of all slots so far
    std::set<std::string> warned_;
};

} // namespace cmpg
