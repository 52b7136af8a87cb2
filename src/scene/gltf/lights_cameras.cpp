// Cameras, punctual lights and the environment of a glTF scene.
#include "scene/gltf/load.h"
#include "scene/gltf/value.h"
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

void addCamera(GltfLoad& load, const NodeInstance& instance, UniqueNames& names) {
    const tinygltf::Node& node = load.model.nodes[instance.node];
    const tinygltf::Camera& source = load.model.cameras[std::size_t(node.camera)];
    Camera camera;
    const std::string fallback = "camera" + std::to_string(load.scene.cameras.size());
    camera.name = uniqueName(!node.name.empty() ? node.name : !source.name.empty() ? source.name : fallback, names);
    const std::optional<glm::mat4> frame = load.cameraFrame(instance.toWorld);
    if (!frame)
        load.document.at(nodePlace(instance.node)).fail("carries a camera, but its transform is singular", "a scale of zero",
                                                        "give the camera's node a scale of 1");
    camera.toWorld = *frame;
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

} // namespace

void loadCameras(GltfLoad& load) {
    UniqueNames names;
    for (const NodeInstance& instance : load.instances)
        if (load.model.nodes[instance.node].camera >= 0) addCamera(load, instance, names);
    load.ensureCamera();
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
        if (light.kind == PunctualLight::Kind::Spot && (inner > outer || !(outer > 0)))
            load.document.at(place + ".spot").fail("has an outer cone that is narrower than the inner one, or of no width");
        // glTF forbids it, but Blender writes it for a blend of 0; the formula of KHR_lights_punctual keeps a narrow edge.
        if (light.kind == PunctualLight::Kind::Spot && inner == outer)
            load.warn(place + ".spot has an inner cone as wide as the outer one: its edge is as sharp as glTF's formula allows");
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
    const std::string name = load.document.name() + ": " + uri.place();
    const RawImage image = decodeImage(load.document.readUri(uri), name, load.imageLimits());
    if (!load.setEnvironment(image, intensity, real(member(source, "rotation"), 0)))
        uri.fail("shows a picture that overflows by its intensity");
}

} // namespace cmpg
