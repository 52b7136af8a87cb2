// A scene on a device as the options want it: what every rendering command starts from.
#include "session/session.h"

#include "base/communicator.h"
#include "base/error.h"
#include "base/log.h"
#include "scene/image_size.h"
#include "scene/scene_file.h"
#include "session/guided_session.h"
#include "session/parameter_values.h"
#include "session/ranks.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace cmpg {

Scene readScene(const Options& options) {
    LoadOptions load;
    load.environment = {options.environment, glm::radians(options.environmentRotation.value_or(0.0f))};
    for (const std::string& definition : options.define) {
        const std::size_t equals = definition.find('=');
        load.definitions[definition.substr(0, equals)] = definition.substr(equals + 1);
    }
    return loadScene(options.input, load);
}

Scene openScene(const Options& options) {
    Scene scene = readScene(options);
    for (const std::string& warning : scene.warnings)
        logWarn(warning);
    for (const std::string& assignment : options.set)
        applySet(scene, assignment);
    return scene;
}

View viewOf(const Options& options, const Scene& scene, const std::string& camera, const Image* like, int defaultWidth) {
    View view;
    view.camera = &scene.camera(camera.empty() ? options.camera : camera);
    if (like) {
        if ((options.width && int(*options.width) != like->width) || (options.height && int(*options.height) != like->height))
            throw Error(ErrorKind::Input,
                        "the target or adjoint is " + std::to_string(like->width) + "x" + std::to_string(like->height) +
                            ", not of the size that --width and --height ask for",
                        "the images were rendered at another size", "leave --width and --height away, or scale the image");
        view.width = like->width;
        view.height = like->height;
        return view;
    }
    std::tie(view.width, view.height) = imageSize(*view.camera, options.width, options.height, defaultWidth);
    return view;
}

RenderConfig renderConfig(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& differentiable) {
    RenderConfig config;
    config.differentiable = differentiable;
    config.maxDepth = options.effectiveDepth(scene.maxDepth);
    config.sampler = options.sampler;
    config.lightSampling = !options.noLightSampling;
    config.allFeatures = options.allFeatures;
    config.memoryBudget = options.memory << 20;
    config.ranks = &ranks();
    config.guiding = usesGuide(options);
    config.learning = usesGuide(options) && options.command == Command::Optimize;
    config.roulette = usesGuide(options) && options.roulette && options.isReverse();
    const bool steps = options.command == Command::Optimize || (options.command == Command::Compare && options.mode == "optimize");
    config.differences = steps && options.recovery.sppDifference > 0;
    config.guideMemory = options.guideMemory << 20;
    config.guide.cellRecords = options.cellRecords;
    config.guide.directionShare = options.directionShare;
    config.guide.forgetting = options.forgetting;
    config.guideShare = options.guideShare;
    config.rouletteEffort = options.rouletteEffort;
    return config;
}

Session::Session(const Options& options, Report& report) : scene(openScene(options)), options_(options), report_(report), record_(options, report) {
    parameters = selectParameters(scene, options.param);
    // What may change is kept as floats from here on.
    for (std::uint32_t p : parameters)
        if (scene.parameters[p].values.empty())
            scene.parameters[p].materialise();
}

void Session::openDevice() {
    if (device_)
        return;
    device_.emplace(Device::Options{.select = options_.device.empty() ? deviceOfRank() : options_.device});
    requireSameRanks(*device_, options_);
}

void Session::prepare(const View& view, const std::filesystem::path& folder, const std::function<Renderer&(const RenderConfig&)>& make) {
    openDevice();
    const RenderConfig config = renderConfig(options_, scene, parameters);
    renderer_ = &make(config);
    report_.seconds.load = std::max(0.0, loading_.seconds() - device_->compileSeconds());
    report_.addDevice(*device_);
    record_.begin(view, config.maxDepth, folder);
}

void Session::finish(const Image* result) {
    if (ranks().size() > 1)
        report_.extra["ranks"] = trafficReport();
    report_.addStatistics(renderer_->statistics());
    report_.addDevice(*device_);
    record_.requireFinite(result);
}

void RunRecord::begin(const View& view, std::uint32_t depth, const std::filesystem::path& folder) {
    report_.width = view.width;
    report_.height = view.height;
    effective_ = options_;
    effective_.maxDepth = depth;
    if (options_.target.size() <= 1) { // several targets have cameras and sizes of their own
        effective_.width = std::uint32_t(view.width);
        effective_.height = std::uint32_t(view.height);
        effective_.camera = view.camera->name;
    }
    printConfiguration(effective_);
    folder_ = folder;
    record({});
}

void RunRecord::record(const std::function<void(Options&)>& change) {
    if (change)
        change(effective_);
    if (!folder_.empty() && ranks().isRoot())
        writeRunJson(effective_, folder_, report_);
}

void RunRecord::requireFinite(const Image* result) const {
    report_.warnOfLosses();
    std::uint64_t lost = 0;
    for (const auto& [kind, count] : report_.dropped)
        lost += count;
    if (result && !std::all_of(result->values.begin(), result->values.end(), [](float v) { return std::isfinite(v); })) {
        Error error = overflowed();
        throw Error(error.kind, "the result holds values that are not finite", error.cause, error.remedy);
    }
    if (tooMany(lost, report_.paths))
        throw overflowed();
}

void warnUnreached(const std::string& parameter, bool anyGradient) {
    if (!anyGradient)
        logWarn("no path reached " + parameter + ": its gradient is zero. The camera does not see it, nor what it lights, within the depth and the samples of this pass");
}

} // namespace cmpg
