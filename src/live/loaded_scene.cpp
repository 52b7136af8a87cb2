// The scene of a session with its targets, and the way back to the values it was loaded with.
#include "live/loaded_scene.h"

#include "session/session.h"
#include "session/targets.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cmpg {
namespace {

std::shared_ptr<const LiveScene> describe(const v1::Scene& scene, std::uint32_t number) {
    auto info = std::make_shared<LiveScene>();
    info->number = number;
    info->file = scene.source();
    info->parameters = scene.parameters();
    info->cameras = scene.cameras();
    info->warnings = scene.warnings();
    const v1::SceneBox box = scene.box();
    info->lower = {box.lower[0], box.lower[1], box.lower[2]};
    info->upper = {box.upper[0], box.upper[1], box.upper[2]};
    info->center = {box.center[0], box.center[1], box.center[2]};
    return info;
}

} // namespace

LoadedScene::LoadedScene(const Options& options, std::uint32_t number) : scene(openScene(options)), info(describe(scene, number)) {}

const v1::CameraInfo& LoadedScene::camera(const std::string& name) const {
    const auto found = std::find_if(info->cameras.begin(), info->cameras.end(), [&](const v1::CameraInfo& c) { return c.name == name; });
    if (name.empty() || found == info->cameras.end()) {
        scene.imageSize(name, 1, 1); // an error here names the cameras there are
        return info->cameras.front();
    }
    return *found;
}

LiveSettings LoadedScene::initialSettings(const Options& options) const {
    LiveSettings s;
    s.scene = info->number;
    std::tie(s.width, s.height) = scene.imageSize(options.camera, int(options.width.value_or(0)), int(options.height.value_or(0)));
    s.camera = camera(options.camera);
    if (!options.param.empty()) {
        for (const std::string& name : parametersOf(options, scene))
            s.parameters.push_back(std::uint32_t(
                std::find_if(info->parameters.begin(), info->parameters.end(), [&](const v1::ParameterInfo& p) { return p.name == name; }) -
                info->parameters.begin()));
    } else if (!info->parameters.empty()) {
        const auto textured = std::find_if(info->parameters.begin(), info->parameters.end(), [](const v1::ParameterInfo& p) { return p.textured; });
        s.parameters = {textured == info->parameters.end() ? 0 : std::uint32_t(textured - info->parameters.begin())};
    }
    return s;
}

void LoadedScene::openTargets(const Options& options) {
    std::vector<v1::Target> opened;
    std::vector<std::string> texts = options.target;
    const std::filesystem::path beside = std::filesystem::path(options.input).parent_path() / "target.exr";
    std::error_code ignored;
    if (texts.empty() && std::filesystem::is_regular_file(beside, ignored))
        texts.push_back(beside.string());
    for (const std::string& text : texts) {
        opened.push_back(cmpg::openTarget(options, scene, text));
        opened.back().from = camera(opened.back().camera.empty() ? options.camera : opened.back().camera);
    }
    targets = std::move(opened);
}

void LoadedScene::openTarget(const Options& options, const std::string& text, const std::string& shown) {
    v1::Target target = cmpg::openTarget(options, scene, text);
    const bool known = std::any_of(info->cameras.begin(), info->cameras.end(), [&](const v1::CameraInfo& c) { return c.name == shown; });
    target.from = camera(!target.camera.empty() ? target.camera : known ? shown : options.camera);
    targets = {std::move(target)};
}

void LoadedScene::setTarget(const v1::CameraInfo& seenBy, Image image) {
    targets = {{.image = std::move(image), .name = "the image of this scene", .from = seenBy}};
}

std::vector<std::string> LoadedScene::names(std::span<const std::uint32_t> parameters) const {
    std::vector<std::string> all;
    for (const std::uint32_t p : parameters)
        all.push_back(parameter(p).name);
    return all;
}

void LoadedScene::remember(std::span<const std::uint32_t> parameters) {
    for (const std::uint32_t p : parameters)
        if (!initial_.contains(p))
            initial_[p] = scene.values(parameter(p).name);
}

void LoadedScene::restore() {
    for (const auto& [p, values] : initial_)
        scene.set(parameter(p).name, values);
}

void LoadedScene::fill(std::span<const std::uint32_t> parameters, float value) {
    remember(parameters);
    for (const std::uint32_t i : parameters) {
        const v1::ParameterInfo& p = parameter(i);
        if (p.slot == "normal") // of a normal map only the straight normal makes sense
            scene.set(p.name, std::vector{0.f, 0.f, 1.f});
        else
            scene.set(p.name, std::vector{std::clamp(value, p.lowest, p.highest)});
    }
}

std::vector<std::uint32_t> LoadedScene::remembered() const {
    std::vector<std::uint32_t> all;
    for (const auto& [p, values] : initial_)
        all.push_back(p);
    return all;
}

std::vector<std::string> LoadedScene::changed() const {
    std::vector<std::string> all;
    for (const auto& [p, values] : initial_)
        if (scene.values(parameter(p).name) != values)
            all.push_back(parameter(p).name);
    return all;
}

} // namespace cmpg
