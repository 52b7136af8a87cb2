// The scene of a session with its targets, and the way back to the values it was loaded with.
#include "live/loaded_scene.h"

#include "session/parameter_values.h"
#include "session/session.h"
#include "session/targets.h"

#include <algorithm>
#include <limits>

namespace cmpg {
namespace {

std::shared_ptr<const LiveScene> describe(const Scene& scene, std::uint32_t number) {
    auto info = std::make_shared<LiveScene>();
    info->number = number;
    info->file = scene.source;
    for (const Parameter& p : scene.parameters)
        info->parameters.push_back({p.name, p.kind, p.width, p.height, p.channels, p.textured, p.lowest(), p.highest()});
    info->cameras = scene.cameras;
    info->center = scene.center;
    info->warnings = scene.warnings;
    if (!scene.geometry.positions.empty()) {
        info->lower = glm::vec3(std::numeric_limits<float>::max());
        info->upper = -info->lower;
    }
    for (const glm::vec3& p : scene.geometry.positions) {
        info->lower = glm::min(info->lower, p);
        info->upper = glm::max(info->upper, p);
    }
    return info;
}

} // namespace

LoadedScene::LoadedScene(const Options& options, std::uint32_t number) : scene(openScene(options)), info(describe(scene, number)) {}

LiveSettings LoadedScene::initialSettings(const Options& options) const {
    LiveSettings s;
    s.scene = info->number;
    const View view = viewOf(options, scene, "");
    s.camera = *view.camera;
    s.width = view.width;
    s.height = view.height;
    if (!options.param.empty()) {
        s.parameters = selectParameters(scene, options.param);
    } else if (!scene.parameters.empty()) {
        const auto textured = std::find_if(scene.parameters.begin(), scene.parameters.end(), [](const Parameter& p) { return p.textured; });
        s.parameters = {textured == scene.parameters.end() ? 0 : std::uint32_t(textured - scene.parameters.begin())};
    }
    return s;
}

void LoadedScene::openTargets(const Options& given) {
    Options options = given;
    options.width = options.height = {}; // of other pictures: a target has its own
    std::vector<Target> opened;
    std::vector<Camera> seen;
    std::vector<std::string> texts = options.target;
    const std::filesystem::path beside = std::filesystem::path(options.input).parent_path() / "target.exr";
    std::error_code ignored;
    if (texts.empty() && std::filesystem::is_regular_file(beside, ignored))
        texts.push_back(beside.string());
    for (const std::string& text : texts) {
        CameraTarget target = loadCameraTarget(options, scene, text);
        seen.push_back(*viewOf(options, scene, target.camera, &target.target.image).camera);
        opened.push_back(std::move(target.target));
    }
    targets = std::move(opened);
    cameras = std::move(seen);
}

void LoadedScene::openTarget(const Options& options, const std::string& text, const std::string& camera) {
    CameraTarget target = loadCameraTarget(options, scene, text);
    const bool known = std::any_of(scene.cameras.begin(), scene.cameras.end(), [&](const Camera& c) { return c.name == camera; });
    const Camera& seen = scene.camera(!target.camera.empty() ? target.camera : known ? camera : options.camera);
    cameras = {seen};
    targets.clear();
    targets.push_back(std::move(target.target));
}

void LoadedScene::setTarget(const Camera& camera, Image image) {
    Target target;
    target.name = "the image of this scene";
    target.image = std::move(image);
    cameras = {camera};
    targets.clear();
    targets.push_back(std::move(target));
}

void LoadedScene::differentiate(std::span<const std::uint32_t> parameters) {
    for (const std::uint32_t p : parameters) {
        scene.parameters[p].materialise();
        initial_.try_emplace(p, scene.parameters[p].values);
    }
}

void LoadedScene::restore() {
    for (const auto& [p, values] : initial_)
        scene.parameters[p].values = values;
}

void LoadedScene::fill(std::span<const std::uint32_t> parameters, float value) {
    differentiate(parameters);
    for (const std::uint32_t i : parameters) {
        Parameter& p = scene.parameters[i];
        if (p.kind == SlotKind::Normal) { // of a normal map only the straight normal makes sense
            for (std::size_t k = 0; k < p.values.size(); ++k)
                p.values[k] = k % 3 == 2 ? 1.f : 0.f;
            continue;
        }
        std::fill(p.values.begin(), p.values.end(), std::clamp(value, p.lowest(), p.highest()));
    }
}

std::vector<std::uint32_t> LoadedScene::remembered() const {
    std::vector<std::uint32_t> all;
    for (const auto& [p, values] : initial_)
        all.push_back(p);
    return all;
}

std::vector<std::uint32_t> LoadedScene::changed() const {
    std::vector<std::uint32_t> all;
    for (const auto& [p, values] : initial_)
        if (scene.parameters[p].values != values)
            all.push_back(p);
    return all;
}

} // namespace cmpg
