// What a scene is, in host memory, without Vulkan: geometry, materials, parameters, lights, cameras.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

struct SceneFormat; // scene/scene_file.h

// The things of a material that can be differentiated, and the environment's radiance: shaders/shared/slots.def.
enum class SlotKind : std::uint32_t {
#define SLOT(number, Name, name, channels, highest, adam, sgd) Name = number,
#include "shared/slots.def"
};
constexpr std::uint32_t kMaterialSlots = std::uint32_t(SlotKind::Radiance); // those of a material
constexpr std::uint32_t kCommonSlots = std::uint32_t(SlotKind::Normal) + 1;    // those that every material has
constexpr std::uint32_t kSlotKinds = kMaterialSlots + 1;
constexpr std::uint32_t kNoParameter = ~0u, kNoMaterial = ~0u;
const char* slotName(SlotKind kind); // "baseColor", ...
std::string slotNames();             // all of them, for messages
std::uint32_t slotChannels(SlotKind kind);
inline bool emitsLight(SlotKind kind) { return kind == SlotKind::Emission || kind == SlotKind::Radiance; }
// Every channel of an image depends on each of its channels: on the components of a normal, or on a colour of which the surface below gets what its
// largest channel leaves. Of other slots, channel c of an image depends on channel c alone.
inline bool mixesChannels(SlotKind kind) { return kind == SlotKind::Normal || kind == SlotKind::SheenColor; }
// How wide a lobe is, or along which direction: images are far from linear in it.
inline bool shapesLobe(SlotKind kind) {
    return kind == SlotKind::Roughness || kind == SlotKind::ClearcoatRoughness || kind == SlotKind::SheenRoughness || kind == SlotKind::Anisotropy;
}

enum class Wrap : std::uint32_t { Repeat, Clamp, Mirror };

constexpr std::uint32_t kMostTexels = 8192; // along an edge of a texture, of a file or made by resize()
constexpr float kLongestNormal = 1e6f;      // as large as a normal map's scale may be

// One parameter: every slot that a material has is one, constant (1x1) or textured.
struct Parameter {
    std::string name; // "<material>.<slot>" or "environment.radiance"
    SlotKind kind = SlotKind::BaseColor;
    std::uint32_t width = 1, height = 1, channels = 3; // channels 1 or 3
    bool textured = false;

    // How a surface point's texture coordinate finds a texel.
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    bool nearest = false;
    std::uint32_t texcoord = 0;             // the material's first (0) or second (1) set
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0}; // columns: image of u, of v, translation (KHR_texture_transform)

    // Either `values` (linear, factor folded in, row-major, channels interleaved) or, for textures nobody changes, `bytes` as in the
    // file with value = scale * decode(byte) + bias. materialise() turns the second form into the first.
    std::vector<float> values;
    std::vector<std::uint8_t> bytes; // channels interleaved
    bool srgb = false;
    glm::vec3 scale{1}, bias{0};

    std::size_t entries() const { return std::size_t(width) * height * channels; }
    void materialise();
    // Range of the values: [0,1], [0,inf) or [-1,1]; see docs/conventions.md. Normals with their map's scale in them may be as long as kLongestNormal.
    float lowest() const;
    float highest() const;
};

// How a material scatters light. What its slots mean, by model:
//
//   model              baseColor (RGB)          specular               roughness
//   MetallicRoughness  glTF's base colour       one: specularFactor    glTF's roughness; and metallic is read
//   Dielectric         what is transmitted      RGB: what is reflected alpha, unless smooth
//   ThinDielectric     what is transmitted      RGB: what is reflected not read: always smooth
//   Conductor          what is reflected        not read               alpha, unless smooth
//   Plastic            the diffuse interior     RGB: what is reflected alpha, unless smooth
//
// The colours multiply what Fresnel's equations say, as Mitsuba's specular_transmittance, specular_reflectance and diffuse_reflectance do; 1 is
// physical. Where a rough material has an anisotropy slot, that is KHR_materials_anisotropy's strength if roughness is glTF's, else Mitsuba's alpha_u, and
// the roughness slot is alpha_v. The specular slot's parameter has three channels where it is RGB. Slots that are not read still have a parameter, as all slots do.
enum class SurfaceModel : std::uint32_t {
    MetallicRoughness, // glTF 2.0, appendix B
    Dielectric,        // a boundary between two media, reflection and refraction; radiance is scaled by the squared index of refraction
    ThinDielectric,    // a pane: both of its boundaries, with all reflections between them, and straight through
    Conductor,         // a metal with a complex index of refraction
    Plastic,           // a dielectric coat over a diffuse base, with all reflections between them
};
enum class Microfacets : std::uint32_t { Ggx, Beckmann };

using SlotParameters = std::array<std::uint32_t, kMaterialSlots>;
constexpr SlotParameters noParameters() {
    SlotParameters none{};
    for (std::uint32_t& parameter : none)
        parameter = kNoParameter;
    return none;
}

struct Material {
    std::string name;
    SlotParameters parameters = noParameters(); // index by SlotKind, into Scene::parameters; kNoParameter: of a lobe that the material has not
    bool hasNormalMap = false;
    SurfaceModel model = SurfaceModel::MetallicRoughness;
    // MetallicRoughness: the index of refraction of the dielectric part. Dielectric, ThinDielectric, Plastic: that of the interior over that of
    // the exterior, > 0; the exterior of a Dielectric is where its front faces (counter-clockwise corners).
    float ior = 1.5f;
    glm::vec3 specularColor{1}; // MetallicRoughness alone: specularColorFactor

    // Not for MetallicRoughness, which is GGX with alpha = roughness^2.
    bool smooth = false;          // an ideal boundary: light goes in single directions, the roughness slot is not read; a ThinDielectric always is
    Microfacets microfacets = Microfacets::Ggx; // unless smooth; Smith masking
    bool roughnessIsAlpha = true; // the roughness slot holds Mitsuba's alpha, [0.001, 1]; false: glTF's roughness, alpha = roughness^2
    glm::vec3 eta{0}, k{1};       // Conductor: index of refraction and extinction over the exterior's index; eta 0, k 1 reflects all
    glm::vec3 absorption{0};      // Dielectric, without alphaMask: of its interior, per unit of length (Beer and Lambert's law)
    bool nonlinear = false;       // Plastic: reflections in the interior change its hue (Mitsuba's `nonlinear`)

    // glTF's numbers of what is kept as its first and second set of texture coordinates.
    std::array<std::uint32_t, 2> texcoordSets{0, 1};

    // Where there is an anisotropy slot: its direction in tangent space by place; ~0u: along the tangent. Into Scene::directionTextures.
    std::uint32_t anisotropyDirection = ~0u;

    // Where there is a clear coat: its own normals in tangent space by place; ~0u: those of what is below. Into Scene::directionTextures.
    std::uint32_t clearcoatNormals = ~0u;

    bool anisotropyByAspect = false; // MetallicRoughness: alphas are alpha / a and alpha a, a = sqrt(1 - 0.9 anisotropy), not those of KHR_materials_anisotropy

    // A blend: light meets the material `blendWith` in place of this one with the probability of the weight slot, which both have then; the mean over
    // both is the weighted sum of what they scatter. What the surface emits and its alpha are the same for both, and the other is no blend.
    std::uint32_t blendWith = kNoMaterial; // into Scene::materials

    // Nothing is scattered to behind, where the shading normal does not point: Mitsuba's BSDFs without twosided. Not for dielectrics.
    bool oneSided = false;

    bool alphaMask = false; // glTF's MASK: there is nothing where alpha is below the cutoff; or BLEND:
    bool coverage = false;  // with alphaMask: a ray meets the surface with probability alpha, alphaCutoff is not read
    float alphaCutoff = 0.5f, alphaFactor = 1;
    std::uint32_t alphaTexture = ~0u; // into Scene::alphaTextures, only for alphaMask
};

// Light goes in single directions at the boundary: of an ideal one, of a pane, and of one between equal media, whose microfacets turn nothing.
inline bool isSmooth(const Material& m) {
    if (m.model == SurfaceModel::MetallicRoughness) return false;
    return m.smooth || m.model == SurfaceModel::ThinDielectric || (m.model == SurfaceModel::Dielectric && m.ior > 0.999f && m.ior < 1.001f);
}

// Of the slot: its microfacets are read, and they are not those of a plastic's coat.
inline bool hasAnisotropy(const Material& m) {
    return m.parameters[std::size_t(SlotKind::Anisotropy)] != kNoParameter && !isSmooth(m) && m.model != SurfaceModel::Plastic;
}

inline bool hasClearcoatNormals(const Material& m) { return m.parameters[std::size_t(SlotKind::Clearcoat)] != kNoParameter && m.clearcoatNormals != ~0u; }

// Of both slots: only over metallic-roughness.
inline bool hasSheen(const Material& m) { return m.model == SurfaceModel::MetallicRoughness && m.parameters[std::size_t(SlotKind::SheenColor)] != kNoParameter; }

// Derivatives by the normal: not of refraction, nor of single directions.
inline bool hasNormalDerivative(const Material& m) { return !isSmooth(m) && m.model != SurfaceModel::Dielectric; }

// Whether a slot that every material has means something to its model.
inline bool readsSlot(const Material& m, SlotKind kind) {
    switch (kind) {
    case SlotKind::Metallic:
        return m.model == SurfaceModel::MetallicRoughness;
    case SlotKind::Specular:
        return m.model != SurfaceModel::Conductor;
    case SlotKind::Roughness:
        return !isSmooth(m);
    default:
        return true;
    }
}

// Alpha of a baseColorTexture of a material with alphaMask.
struct AlphaTexture {
    std::uint32_t width = 1, height = 1, texcoord = 0;
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    bool nearest = false;
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0};
    std::vector<std::uint8_t> alpha;
};

// Directions in tangent space. In which a material's microfacets are rougher: the lengths say how they mix between texels, and nothing else. Or a clear
// coat's normals: x and y of unit vectors, whose z is not below 0.
struct DirectionTexture {
    std::uint32_t width = 1, height = 1, texcoord = 0;
    Wrap wrapU = Wrap::Repeat, wrapV = Wrap::Repeat;
    bool nearest = false;
    glm::mat3x2 uvTransform{1, 0, 0, 1, 0, 0};
    std::vector<glm::vec2> directions; // in [-1, 1]
};

struct Triangle {
    std::array<std::uint32_t, 3> vertices;
    std::uint32_t material;
};

// World space. Optional arrays are empty when no primitive of the scene has them; otherwise filled for every vertex.
struct Geometry {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals; // zero vector: the triangle's geometric normal is used
    std::vector<glm::vec2> uv0, uv1;
    std::vector<glm::vec4> tangents; // xyz unit, w = +-1; zero: the shader derives them from uvs; filled only where a normal map, of a coat too, or an anisotropy needs them
    std::vector<glm::vec4> colors;   // linear, multiplies baseColor (alpha multiplies alpha)
    std::vector<Triangle> triangles;
};

// How a pixel weighs what the picture shows around its middle (shaders/lib/pixel_filter.glsl).
struct PixelFilter {
    enum class Kind : std::uint32_t { Box, Tent, Gaussian } kind = Kind::Box; // Box: the mean over the pixel's square
    float radius = 0.5f, deviation = 0.5f; // in pixels; the deviation of a Gaussian, which ends at its radius
};

struct Camera {
    std::string name;
    glm::mat4 toWorld{1}; // camera looks along -Z
    bool orthographic = false;
    float yfov = 0.8f;            // radians, vertical
    float ymag = 1;               // orthographic: half height
    std::optional<float> aspect;  // as in the file; used for the default size only
    std::optional<glm::uvec2> size; // width and height in pixels, where the file says
    glm::vec2 center{0}; // the middle of the picture from the point that the camera looks at, in half heights of the picture: right, up
    PixelFilter filter;
};

struct PunctualLight {
    enum class Kind : std::uint32_t { Point, Spot, Directional } kind = Kind::Point;
    glm::vec3 position{0}, direction{0, 0, -1}; // direction the light travels
    glm::vec3 intensity{1};                     // colour * intensity: W/sr, or W/m^2 for directional
    float range = 0;                            // 0 = unlimited
    float innerCos = 1, outerCos = 0.7071f;
    bool byAngle = false; // a spot falls off with the angle between the cones, as Mitsuba's does; else with the square of the cosine, as glTF's
};

struct Environment {
    std::uint32_t parameter; // radiance, W x H x 3 (intensity folded in); latitude-longitude, a single row for all latitudes
    float rotation = 0;      // radians about +y; world = R_y(rotation) * environment
    bool replaced = false;   // by LoadOptions::environment: the scene's own file does not have it
};

struct Scene {
    std::string source; // path it came from
    const SceneFormat* format = nullptr; // that it was read from; nullptr: built in memory
    std::map<std::string, std::string> definitions; // LoadOptions::definitions that it was read with
    std::vector<std::filesystem::path> files; // that it names and was read from, its own among them, links followed
    Geometry geometry;
    std::vector<Material> materials;
    std::vector<AlphaTexture> alphaTextures;
    std::vector<DirectionTexture> directionTextures;
    std::vector<Parameter> parameters; // of all materials, then the environment's
    std::vector<PunctualLight> lights;
    std::optional<Environment> environment;
    std::vector<Camera> cameras; // never empty
    std::map<std::string, std::uint32_t> aliases; // other names of parameters
    std::uint32_t maxDepth = 8;
    glm::dvec3 center{0}; // subtracted from all positions (re-centred in double when the scene is far from the origin)
    std::vector<std::string> warnings;
    std::uint64_t skippedTriangles = 0; // degenerate

    // Index of the parameter, or Error(Usage) listing the nearest names.
    std::uint32_t parameter(const std::string& name) const;
    // All parameters a glob selects, in order; Error(Usage) when none.
    std::vector<std::uint32_t> select(const std::string& glob) const;
    // All that names and globs select to differentiate by, each once, in order of first mention. A glob leaves out what has no derivative or is not read by its
    // material, and appends the names to `left` if given; what is meant by its name stays, to be refused or warned of with the reason.
    std::vector<std::uint32_t> selectDifferentiable(std::span<const std::string> globs, std::vector<std::string>* left = nullptr) const;
    // By parameter: whether it has no derivative or is not read by its material.
    std::vector<bool> withoutDerivative() const;
    const Camera& camera(const std::string& name) const; // "" = first
    // Of a slot that kernels hold above a floor, the floor: values below it look the same, and have no derivative. Of others 0.
    float floorOf(std::uint32_t parameter) const;
};

// The set of texture coordinates, 0 or 1, that tangents of a material follow where the file has none: of its normal map; without one, of that of its
// clear coat; without that, of the texture of its anisotropy.
inline std::uint32_t tangentTexcoord(const Scene& scene, const Material& m) {
    if (m.hasNormalMap)
        return scene.parameters[m.parameters[std::size_t(SlotKind::Normal)]].texcoord;
    if (hasClearcoatNormals(m))
        return scene.directionTextures[m.clearcoatNormals].texcoord;
    return m.anisotropyDirection != ~0u ? scene.directionTextures[m.anisotropyDirection].texcoord : 0;
}

// Whether anything shines: a light, an environment, or a material that emits, seen or not.
bool hasLight(const Scene& scene);

// Of the triangles' positions and order: equal for equal geometry, on every machine.
std::uint64_t geometryHash(const Scene& scene);

} // namespace cmpg
