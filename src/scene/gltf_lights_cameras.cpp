// Cameras, punctual lights and the environment of a glTF scene.
#include "scene/gltf_load.h"
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
glm::vec3 place(const GltfLoad& load, const glm::dmat4& toWorld) { return glm::vec3(glm::dvec3(toWorld[3]) - load.scene.center); }

// The node's axes made orthonormal: scale and shear of a node do not bend a camera, a mirrored node mirrors it.
glm::mat4 cameraFrame(const GltfLoad& load, const NodeInstance& instance, const JsonView& node) {
    const glm::dmat3 m(instance.toWorld);
    const glm::dvec3 z = glm::normalize(m[2]);
    const glm::dvec3 y = glm::normalize(m[1] - z * glm::dot(m[1], z));
    const glm::dvec3 across = m[0] - z * glm::dot(m[0], z);
    const glm::dvec3 x = glm::normalize(across - y * glm::dot(across, y));
    const double sum = glm::dot(x, x) + glm::dot(y, y) + glm::dot(z, z);
    if (!std::isfinite(sum))
        node.fail("carries a camera, but its transform is singular", "a scale of zero", "give the camera's node a scale of 1");
    return glm::mat4(glm::dmat4(glm::dvec4(x, 0), glm::dvec4(y, 0), glm::dvec4(z, 0), glm::dvec4(place(load, instance.toWorld), 1)));
}

void addCamera(GltfLoad& load, const NodeInstance& instance, const JsonView& node, const JsonView& json, std::set<std::string>& names) {
    Camera camera;
    const std::string fallback = "camera" + std::to_string(load.scene.cameras.size());
    camera.name = uniqueName(node["name"].string(json["name"].string(fallback)), names);
    camera.toWorld = cameraFrame(load, instance, node);
    const std::string type = json["type"].string();
    if (type == "perspective") {
        const JsonView lens = json["perspective"];
        if (!lens["yfov"].exists()) lens["yfov"].fail("is missing");
        camera.yfov = lens["yfov"].real(0, 1e-4f, glm::pi<float>() - 1e-4f);
        if (lens["aspectRatio"].exists()) camera.aspect = lens["aspectRatio"].real(1, 1e-4f, 1e4f);
    } else if (type == "orthographic") {
        const JsonView lens = json["orthographic"];
        camera.orthographic = true;
        // Exporters write negative magnifications for flipped views; only their size matters to us.
        const float x = std::abs(lens["xmag"].real(1)), y = std::abs(lens["ymag"].real(1));
        if (!(x > kTiny && y > kTiny)) lens.fail("has a view of no size");
        camera.ymag = y;
        camera.aspect = x / y;
    } else {
        json["type"].fail("is \"" + type + "\"; glTF has perspective and orthographic");
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
    const JsonView nodes = load.root["nodes"], cameras = load.root["cameras"];
    std::set<std::string> names;
    for (const NodeInstance& instance : load.instances) {
        const JsonView node = nodes.at(instance.node);
        if (const auto camera = node["camera"].index(cameras.size(), "camera"))
            addCamera(load, instance, node, cameras.at(*camera), names);
    }
    if (!load.scene.cameras.empty()) return;
    load.warn("the scene has no camera: a default one frames its bounding box from +Z");
    load.scene.cameras.push_back(framingCamera(load.scene.geometry));
}

void loadLights(GltfLoad& load) {
    const JsonView nodes = load.root["nodes"], lights = load.root["extensions"]["KHR_lights_punctual"]["lights"];
    for (const NodeInstance& instance : load.instances) {
        const JsonView reference = nodes.at(instance.node)["extensions"]["KHR_lights_punctual"]["light"];
        const auto index = reference.index(lights.size(), "light");
        if (!index) continue;
        const JsonView json = lights.at(*index);
        PunctualLight light;
        const std::string type = json["type"].string();
        if (type == "point")
            light.kind = PunctualLight::Kind::Point;
        else if (type == "spot")
            light.kind = PunctualLight::Kind::Spot;
        else if (type == "directional")
            light.kind = PunctualLight::Kind::Directional;
        else
            json["type"].fail("is \"" + type + "\"; the extension has point, spot and directional");
        light.position = place(load, instance.toWorld);
        const glm::dvec3 forward = -glm::dvec3(instance.toWorld[2]);
        if (light.kind != PunctualLight::Kind::Point) {
            if (!(glm::length(forward) > 0)) nodes.at(instance.node).fail("carries a light, but its transform is singular");
            light.direction = glm::vec3(glm::normalize(forward));
        }
        light.intensity = glm::max(json["color"].vec(glm::vec3(1)), 0.0f) * json["intensity"].real(1, 0, kAny);
        if (!(glm::compMax(light.intensity) <= kAny)) json["intensity"].fail("times the colour is too large a number");
        light.range = json["range"].real(0, 0, kAny);
        const float outer = json["spot"]["outerConeAngle"].real(glm::quarter_pi<float>(), 0, glm::half_pi<float>());
        const float inner = json["spot"]["innerConeAngle"].real(0, 0, glm::half_pi<float>());
        if (light.kind == PunctualLight::Kind::Spot && inner >= outer) json["spot"].fail("has an inner cone as wide as the outer one");
        light.innerCos = std::cos(inner);
        light.outerCos = std::cos(outer);
        load.scene.lights.push_back(light);
    }
}

void loadEnvironment(GltfLoad& load) {
    const JsonView extras = load.sceneJson["extras"];
    if (!extras.isObject() || !extras["environment"].exists()) return;
    const JsonView json = extras["environment"];
    const float intensity = json["intensity"].real(1, 0, kAny);
    const std::size_t edge = load.options.maxTextureSize;
    const std::string name = load.document.name() + ": " + json["uri"].place();
    const RawImage image = decodeImage(load.document.readUri(json["uri"]), name, {.maxEdge = edge, .maxPixels = edge * edge});

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
        json["intensity"].fail("makes the environment's radiance overflow");
    load.scene.environment = Environment{std::uint32_t(load.scene.parameters.size()), json["rotation"].real(0)};
    load.scene.parameters.push_back(std::move(p));
}

} // namespace cmpg
