// Cameras, punctual lights and the environment of a glTF scene.
#include "scene/gltf_load.h"
#include "scene/gltf_value.h"
#include "scene/image_decode.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtx/component_wise.hpp>
#include <limits>

namespace cmpg {
namespace {

constexpr float kAny = std::numeric_limits<float>::max();
constexpr float kTiny = std::numeric_limits<float>::min();

// World space as stored: shifted by the centre that positions were shifted by.
glm::vec3 worldPlace(const GltfLoad& load, const glm::dmat4& toWorld) { return glm::vec3(glm::dvec3(toWorld[3]) - load.scene.center); }

// The node's axes made orthonormal: scale and shear of a node do not bend a camera, a mirrored node mirrors it.
glm::mat4 cameraFrame(const GltfLoad& load, const NodeInstance& instance) {
    const glm::dmat3 m(instance.toWorld);
    const glm::dvec3 z = glm::normalize(m[2]);
    const glm::dvec3 y = glm::normalize(m[1] - z * glm::dot(m[1], z));
    const glm::dvec3 across = m[0] - z * glm::dot(m[0], z);
    const glm::dvec3 x = glm::normalize(across - y * glm::dot(across, y));
    const double sum = glm::dot(x, x) + glm::dot(y, y) + glm::dot(z, z);
    if (!std::isfinite(sum))
        load.document.at(nodePlace(instance.node)).fail("carries a camera, but its transform is singular", "a scale of zero",
                                                        "give the camera's node a scale of 1");
    return glm::mat4(glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(worldPlace(load, instance.toWorld), 1)));
}

void addCamera(GltfLoad& load, const NodeInstance& instance, UniqueNames& names) {
    const tinygltf::Node& node = load.model.nodes[instance.node];
    const tinygltf::Camera& source = load.model.cameras[std::size_t(node.camera)];
    Camera camera;
    const std::string fallback = "camera" + std::to_string(load.scene.cameras.size());
    camera.name = uniqueName(!node.name.empty() ? node.name : !source.name.empty() ? source.name : fallback, names);
    camera.toWorld = cameraFrame(load, instance);
    camera.orthographic = source.type == "orthographic";
    if (camera.orthographic) {
        // Exporters write negative magnifications for flipped views; only their size matters to us.
        const float x = std::abs(float(source.orthographic.xmag)), y = std::abs(float(source.orthographic.ymag));
        if (!(x > kTiny && y > kTiny))
            load.document.at("cameras[" + std::to_string(node.camera) + "].orthographic").fail("has a view of no size");
        camera.ymag = y;
        camera.aspect = x / y;
    } else {
        camera.yfov = float(source.perspective.yfov);
        if (source.perspective.aspectRatio > 0) camera.aspect = float(source.perspective.aspectRatio);
    }
    load.scene.cameras.push_back(std::move(camera));
}

// Looks along -Z at the bounding sphere, which just fits a square image.
Camera framingCamera(const Geometry& geometry) {
    glm::vec3 low(0), high(0);
    for (const glm::vec3& p : geometry.positions) {
        const bool first = &p == geometry.positions.data();
        low = first ? p : glm::min(low, p);
        high = first ? p : glm::max(high, p);
    }
    Camera camera;
    camera.name = "default";
    const float radius = std::max(0.5f * glm::length(high - low), kTiny);
    camera.toWorld[3] = glm::vec4((low + high) * 0.5f + glm::vec3(0, 0, radius / std::sin(camera.yfov / 2)), 1);
    return camera;
}

} // namespace

void loadCameras(GltfLoad& load) {
    UniqueNames names;
    for (const NodeInstance& instance : load.instances)
        if (load.model.nodes[instance.node].camera >= 0) addCamera(load, instance, names);
    if (!load.scene.cameras.empty()) return;
    load.warn("the scene has no camera: a default one frames its bounding box from +Z");
    load.scene.cameras.push_back(framingCamera(load.scene.geometry));
}

void loadLights(GltfLoad& load) {
    for (const NodeInstance& instance : load.instances) {
        const tinygltf::Value& reference = extension(load.model.nodes[instance.node].extensions, "KHR_lights_punctual");
        const int index = int(number(member(reference, "light"), -1));
        if (index < 0) continue;
        const tinygltf::Light& source = load.model.lights[std::size_t(index)];
        const std::string place = "extensions.KHR_lights_punctual.lights[" + std::to_string(index) + "]";
        PunctualLight light;
        light.kind = source.type == "spot"          ? PunctualLight::Kind::Spot
                     : source.type == "directional" ? PunctualLight::Kind::Directional
                                                    : PunctualLight::Kind::Point;
        light.position = worldPlace(load, instance.toWorld);
        const glm::dvec3 forward = -glm::dvec3(instance.toWorld[2]);
        if (light.kind != PunctualLight::Kind::Point) {
            if (!(glm::length(forward) > 0))
                load.document.at(nodePlace(instance.node)).fail("carries a light, but its transform is singular");
            light.direction = glm::vec3(glm::normalize(forward));
        }
        light.intensity = glm::max(vec(source.color, glm::vec3(1)), 0.0f) * float(source.intensity);
        if (!(glm::compMax(light.intensity) <= kAny)) load.document.at(place + ".intensity").fail("times the colour is too large a number");
        light.range = float(source.range);
        const auto inner = float(source.spot.innerConeAngle), outer = float(source.spot.outerConeAngle);
        if (light.kind == PunctualLight::Kind::Spot && inner >= outer)
            load.document.at(place + ".spot").fail("has an inner cone as wide as the outer one");
        light.innerCos = std::cos(inner);
        light.outerCos = std::cos(outer);
        load.scene.lights.push_back(light);
    }
}

void loadEnvironment(GltfLoad& load) {
    if (!load.shown) return;
    const tinygltf::Value& source = member(load.shown->extras, "environment");
    if (!source.IsObject()) return;
    const float intensity = real(member(source, "intensity"), 1);
    const auto shown = std::uint32_t(load.shown - load.model.scenes.data());
    const JsonView uri = load.document.root()["scenes"].at(shown)["extras"]["environment"]["uri"];
    const std::size_t edge = load.options.maxTextureSize;
    const std::string name = load.document.name() + ": " + uri.place();
    const RawImage image = decodeImage(load.document.readUri(uri), name, {.maxEdge = edge, .maxPixels = edge * edge});

    Parameter p;
    p.name = "environment.radiance";
    p.kind = SlotKind::Radiance;
    p.textured = true;
    p.width = image.width;
    p.height = image.height;
    p.wrapV = Wrap::Clamp;
    p.values.resize(p.entries());
    std::size_t negative = 0;
    for (std::size_t i = 0; i < image.pixels(); ++i)
        for (std::uint32_t c = 0; c < 3; ++c) {
            const std::size_t from = i * image.channels + image.channel(c);
            const float code = image.bytes.empty() ? image.values[from] : float(image.bytes[from]) / 255.0f;
            const float value = (image.linear ? code : srgbDecode(code)) * intensity;
            negative += value < 0;
            p.values[i * 3 + c] = std::max(value, 0.0f);
        }
    if (negative) load.warn(p.name + ": " + std::to_string(negative) + " negative values were clamped to 0");
    if (!std::all_of(p.values.begin(), p.values.end(), [](float v) { return std::isfinite(v); }))
        uri.fail("shows a picture that overflows by its intensity");
    load.scene.environment = Environment{std::uint32_t(load.scene.parameters.size()), real(member(source, "rotation"), 0)};
    load.scene.parameters.push_back(std::move(p));
}

} // namespace cmpg
