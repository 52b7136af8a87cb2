// Scenes of the library's surface.
#include "base/error.h"
#include "library/states.h"
#include "scene/camera_ray.h"
#include "scene/image_size.h"
#include "scene/parameter_size.h"
#include "scene/parameter_values.h"
#include "scene/pixel_filter.h"
#include "scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>

namespace cmpg::v1 {

ParameterInfo describe(const cmpg::Parameter& p) {
    return {p.name, slotName(p.kind), int(p.height), int(p.width), int(p.channels), p.lowest(), p.highest(), p.textured};
}

CameraInfo describe(const Camera& camera) {
    CameraInfo info{.name = camera.name, .aspect = camera.aspect, .orthographic = camera.orthographic, .yfov = camera.yfov, .ymag = camera.ymag};
    std::copy_n(glm::value_ptr(camera.toWorld), info.toWorld.size(), info.toWorld.begin());
    return info;
}

Camera movedCamera(const cmpg::Scene& scene, const CameraInfo& to) {
    require(std::all_of(to.toWorld.begin(), to.toWorld.end(), [](float v) { return std::isfinite(v); }), "camera", "at a finite place");
    require(to.orthographic || (to.yfov > 0 && to.yfov < 3.1415926f), "camera", "one with an angle above 0 and below pi");
    require(!to.orthographic || (to.ymag > 0 && std::isfinite(to.ymag)), "camera", "one with a height above 0");
    const auto named = std::find_if(scene.cameras.begin(), scene.cameras.end(), [&](const Camera& c) { return c.name == to.name; });
    Camera camera = named == scene.cameras.end() ? scene.cameras.front() : *named;
    camera.toWorld = glm::make_mat4(to.toWorld.data());
    camera.orthographic = to.orthographic;
    camera.yfov = to.yfov;
    camera.ymag = to.ymag;
    if (to.aspect && to.aspect != camera.aspect) {
        require(*to.aspect > 0 && std::isfinite(*to.aspect), "camera", "one with an aspect ratio above 0");
        camera.aspect = to.aspect;
        camera.size.reset(); // the file's, which has its aspect
    }
    return camera;
}

namespace {

std::pair<int, int> sizeOf(const Camera& camera, int width, int height) {
    require(width >= 0 && width <= kMostEdge, "width", "from 1 to 32768, or 0");
    require(height >= 0 && height <= kMostEdge, "height", "from 1 to 32768, or 0");
    const auto given = [](int edge) { return edge > 0 ? std::optional(std::uint32_t(edge)) : std::nullopt; };
    return cmpg::imageSize(camera, given(width), given(height), 512);
}

} // namespace

cmpg::Scene copyOf(Scene::State& state, std::span<const std::string> globs, std::vector<std::uint32_t>& parameters,
                   std::vector<std::uint64_t>& revisions) {
    const std::lock_guard lock(state.mutex);
    parameters = state.scene.selectDifferentiable(globs);
    revisions = state.revisions;
    cmpg::Scene copy = state.scene;
    for (const std::uint32_t p : parameters)
        copy.parameters[p].materialise();
    return copy;
}

Scene Scene::load(const std::filesystem::path& file, const SceneOptions& options) {
    LoadOptions load;
    load.environment = {options.environment, glm::radians(options.environmentRotation)};
    load.definitions = options.define;
    if (options.filter)
        load.filter = pixelFilter(*options.filter);
    const auto state = std::make_shared<State>();
    state->scene = loadScene(file, load);
    state->revisions.resize(state->scene.parameters.size());
    return Scene(state);
}

std::vector<std::string> Scene::extensions() {
    std::vector<std::string> all;
    for (const SceneFormat* format : sceneFormats())
        all.insert(all.end(), format->extensions.begin(), format->extensions.end());
    return all;
}

Scene Scene::copy() const {
    const std::lock_guard lock(state_->mutex);
    const auto state = std::make_shared<State>();
    state->scene = state_->scene;
    state->revisions = state_->revisions;
    return Scene(state);
}

std::string Scene::source() const { return state_->scene.source; }
std::vector<std::string> Scene::warnings() const { return state_->scene.warnings; }
std::uint32_t Scene::maxDepth() const { return state_->scene.maxDepth; }

std::vector<CameraInfo> Scene::cameras() const {
    std::vector<CameraInfo> cameras;
    for (const Camera& camera : state_->scene.cameras)
        cameras.push_back(describe(camera));
    return cameras;
}

std::pair<int, int> Scene::imageSize(const std::string& camera, int width, int height) const {
    return sizeOf(state_->scene.camera(camera), width, height);
}

SceneBox Scene::box() const {
    glm::vec3 lower(0), upper(0);
    const std::vector<glm::vec3>& positions = state_->scene.geometry.positions;
    if (!positions.empty()) {
        lower = glm::vec3(std::numeric_limits<float>::max());
        upper = -lower;
    }
    for (const glm::vec3& p : positions) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    const glm::dvec3& center = state_->scene.center;
    return {{lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}, {center.x, center.y, center.z}};
}

std::optional<SurfacePoint> Scene::pick(const CameraInfo& camera, int width, int height, float x, float y) const {
    const cmpg::Scene& scene = state_->scene; // what is read here never changes
    const Camera moved = movedCamera(scene, camera);
    const auto [w, h] = sizeOf(moved, width, height);
    const std::optional<SurfaceHit> hit = castRay(scene, CameraRays(moved, w, h).at(x, y));
    if (!hit)
        return {};
    const glm::vec3 &p = hit->position, &n = hit->normal;
    return SurfacePoint{{p.x, p.y, p.z}, {n.x, n.y, n.z}, hit->distance, scene.materials[scene.geometry.triangles[hit->triangle].material].name};
}

std::vector<ParameterInfo> Scene::parameters() const {
    const std::lock_guard lock(state_->mutex);
    std::vector<ParameterInfo> parameters;
    for (const cmpg::Parameter& parameter : state_->scene.parameters)
        parameters.push_back(describe(parameter));
    return parameters;
}

ParameterInfo Scene::parameter(const std::string& name) const {
    const std::lock_guard lock(state_->mutex);
    return describe(state_->scene.parameters[state_->scene.parameter(name)]);
}

std::vector<std::string> Scene::select(const std::string& glob) const {
    std::vector<std::string> names;
    for (const std::uint32_t index : state_->scene.select(glob))
        names.push_back(state_->scene.parameters[index].name);
    return names;
}

std::vector<float> Scene::values(const std::string& name, ParameterInfo* info) const {
    const std::lock_guard lock(state_->mutex);
    const cmpg::Parameter& parameter = state_->scene.parameters[state_->scene.parameter(name)];
    if (info)
        *info = describe(parameter);
    return valuesOf(parameter);
}

void Scene::set(const std::string& name, std::span<const float> values) {
    const std::lock_guard lock(state_->mutex);
    const std::uint32_t index = state_->scene.parameter(name);
    cmpg::Parameter& parameter = state_->scene.parameters[index];
    const bool all = values.size() == parameter.entries();
    if (!all && values.size() != 1 && values.size() != parameter.channels)
        throw Error(ErrorKind::Usage,
                    name + " has " + std::to_string(parameter.entries()) + " values, but " + std::to_string(values.size()) + " were given",
                    "its height, width and channels are " + std::to_string(parameter.height) + ", " + std::to_string(parameter.width) + " and " +
                        std::to_string(parameter.channels),
                    "give as many, one per channel, or one");
    setValues(parameter, all ? std::vector<float>(values.begin(), values.end()) : filled(parameter, values));
    ++state_->revisions[index];
}

void Scene::resize(const std::string& name, int width, int height) {
    const std::lock_guard lock(state_->mutex);
    const std::uint32_t index = state_->scene.parameter(name);
    const std::string range = "from 1 to " + std::to_string(kMostTexels);
    require(width >= 1 && width <= int(kMostTexels), "width", range);
    require(height >= 1 && height <= int(kMostTexels), "height", range);
    if (const cmpg::Parameter& now = state_->scene.parameters[index]; int(now.width) == width && int(now.height) == height)
        return; // renderers have nothing to follow
    cmpg::resize(state_->scene, index, std::uint32_t(width), std::uint32_t(height));
    ++state_->revisions[index];
}

std::filesystem::path Scene::exportTo(const std::filesystem::path& folder) const {
    const std::lock_guard lock(state_->mutex);
    std::vector<std::uint32_t> changed;
    for (std::size_t p = 0; p < state_->revisions.size(); ++p)
        if (state_->revisions[p] > 0)
            changed.push_back(std::uint32_t(p));
    exportScene(state_->scene, changed, folder);
    return folder / state_->scene.format->exported;
}

std::filesystem::path Scene::exportTo(const std::filesystem::path& folder, std::span<const std::string> parameters) const {
    const std::lock_guard lock(state_->mutex);
    std::vector<std::uint32_t> changed;
    for (const std::string& name : parameters)
        changed.push_back(state_->scene.parameter(name));
    exportScene(state_->scene, changed, folder);
    return folder / state_->scene.format->exported;
}

} // namespace cmpg::v1
