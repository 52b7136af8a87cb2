// Scenes of the library's surface.
#include "base/error.h"
#include "library/states.h"
#include "scene/parameter_values.h"
#include "scene/pixel_filter.h"
#include "scene/scene_file.h"

#include <algorithm>

namespace cmpg::v1 {

ParameterInfo describe(const cmpg::Parameter& p) {
    return {p.name, slotName(p.kind), int(p.height), int(p.width), int(p.channels), p.lowest(), p.highest()};
}

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
        cameras.push_back({camera.name, camera.aspect});
    return cameras;
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

std::vector<float> Scene::values(const std::string& name) const {
    const std::lock_guard lock(state_->mutex);
    return valuesOf(state_->scene.parameters[state_->scene.parameter(name)]);
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

void Scene::exportTo(const std::filesystem::path& folder) const {
    const std::lock_guard lock(state_->mutex);
    std::vector<std::uint32_t> changed;
    for (std::size_t p = 0; p < state_->revisions.size(); ++p)
        if (state_->revisions[p] > 0)
            changed.push_back(std::uint32_t(p));
    exportScene(state_->scene, changed, folder);
}

} // namespace cmpg::v1
