// A scene on a device as the options want it: what every rendering command starts from.
#include "session/session.h"

#include "base/communicator.h"
#include "base/error.h"
#include "base/log.h"
#include "library/states.h"
#include "scene/features.h"
#include "scene/image_size.h"
#include "session/library_options.h"
#include "session/parameter_values.h"
#include "session/ranks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace cmpg {

namespace {

v1::Scene load(const Options& options, bool setValues) {
    v1::SceneOptions given{.environment = options.environment, .environmentRotation = options.environmentRotation.value_or(0.0f)};
    for (const std::string& definition : options.define) {
        const std::size_t equals = definition.find('=');
        given.define[definition.substr(0, equals)] = definition.substr(equals + 1);
    }
    if (!options.filter.empty())
        given.filter = v1::ReconstructionFilter::parse(options.filter);
    v1::Scene scene = v1::Scene::load(options.input, given);
    v1::Scene::State& state = *scene.state();
    const auto changed = [&](const std::vector<std::uint32_t>& parameters) { // which what is exported must have, recovered or not
        for (const std::uint32_t p : parameters)
            ++state.revisions[p];
    };
    for (const std::string& assignment : options.texture)
        changed(applyTexture(state.scene, assignment));
    if (!setValues)
        return scene;
    for (const std::string& warning : scene.warnings())
        logWarn(warning);
    for (const std::string& assignment : options.set)
        changed(applySet(state.scene, assignment));
    warnOfUnsampledLights(options, state.scene);
    return scene;
}

} // namespace

Scene readScene(const Options& options) { return std::move(load(options, false).state()->scene); }
v1::Scene openScene(const Options& options) { return load(options, true); }

std::vector<std::string> parametersOf(const Options& options, const v1::Scene& scene) {
    const Scene& host = scene.state()->scene;
    std::vector<std::string> names;
    for (const std::uint32_t p : selectParameters(host, options.param))
        names.push_back(host.parameters[p].name);
    return names;
}

SeenView viewOf(const Options& options, const Scene& scene, const std::string& camera, const Image* like, int defaultWidth) {
    const Camera& seenBy = scene.camera(camera.empty() ? options.camera : camera);
    SeenView view{.camera = seenBy.name};
    if (like) {
        if ((options.width && int(*options.width) != like->width) || (options.height && int(*options.height) != like->height))
            throw Error(ErrorKind::Input,
                        "the adjoint is " + std::to_string(like->width) + "x" + std::to_string(like->height) +
                            ", not of the size that --width and --height ask for",
                        "it was made at another size", "leave --width and --height away");
        view.width = like->width;
        view.height = like->height;
        return view;
    }
    std::tie(view.width, view.height) = imageSize(seenBy, options.width, options.height, defaultWidth);
    return view;
}

Session::Session(const Options& options, Report& report)
    : scene(openScene(options)), parameters(parametersOf(options, scene)), options_(options), report_(report), record_(options, report) {}

const Scene& Session::host() const { return scene.state()->scene; }
const Parameter& Session::parameter(std::size_t index) const { return host().parameters[host().parameter(parameters[index])]; }

v1::Device& Session::openDevice() {
    if (!device_) {
        device_.emplace(options_.device);
        if (options_.kernelTimes)
            device_->timeKernels();
        requireSameOptions(options_);
    }
    return *device_;
}

const Device& Session::device() const { return device_->state()->device; }

double Session::compileSeconds() const { return device().compileSeconds(); }

void Session::begin(const SeenView& view, const std::filesystem::path& folder) {
    report_.seconds.load = std::max(0.0, loading_.seconds() - compileSeconds());
    report_.addDevice(device());
    record_.begin(view, options_.effectiveDepth(host().maxDepth), folder);
}

void Session::add(const v1::PassReport& pass) {
    report_.add(pass);
    report_.seconds.guide += pass.learningSeconds;
}

void Session::tellSampling(const v1::PassReport& pass) {
    auto plain = nlohmann::ordered_json::object(), with = plain;
    for (const MethodFigures& f : pass.figures)
        (f.roulette ? with : plain)[nameOf(f.sampling, kSamplings)] = {{"variance", f.variance}, {"rays_per_path", f.raysPerPath}, {"passes", f.passes}};
    report_.extra["sampling"] = {{"kind", nameOf(pass.sampling, kSamplings)}, {"roulette", pass.roulette}, {"figures", plain}, {"roulette_figures", with}};
    if (!usesGuide(options_) || options_.quiet)
        return;
    std::ostream& out = textOut(options_);
    out << "  drawn by          " << nameOf(pass.sampling, kSamplings) << (pass.roulette ? ", roulette and splitting" : "") << '\n';
    for (const MethodFigures& f : pass.figures)
        out << "    " << nameOf(f.sampling, kSamplings) << (f.roulette ? " + roulette" : "") << ": variance " << f.variance << ", " << f.raysPerPath << " rays a path\n";
}

bool Session::savesGuide() const { return !options_.saveGuide.empty() && ranks().isRoot(); }

void Session::finish(const Image* result) {
    if (ranks().size() > 1)
        report_.extra["ranks"] = trafficReport();
    report_.addDevice(device());
    record_.requireFinite(result);
}

void RunRecord::begin(const SeenView& view, std::uint32_t depth, const std::filesystem::path& folder) {
    report_.width = view.width;
    report_.height = view.height;
    effective_ = options_;
    effective_.maxDepth = depth;
    if (options_.target.size() <= 1) { // several targets have cameras and sizes of their own
        effective_.width = std::uint32_t(view.width);
        effective_.height = std::uint32_t(view.height);
        effective_.camera = view.camera;
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

void warnUnreached(const Scene& scene, const std::string& parameter, bool anyGradient) {
    if (anyGradient)
        return;
    const std::uint32_t index = scene.parameter(parameter);
    const float floor = scene.floorOf(index);
    const std::vector<float> values = floor > 0 ? valuesOf(scene.parameters[index]) : std::vector<float>();
    if (!values.empty() && std::all_of(values.begin(), values.end(), [&](float v) { return v <= floor; })) {
        char text[160];
        std::snprintf(text, sizeof text, ": its gradient is zero, since values of %.3g and below look the same. Begin well above (--set)", double(floor));
        logWarn(parameter + text);
    } else if (scene.withoutDerivative()[index]) {
        logWarn("the gradient of " + parameter + " is zero, as the model of its material has no use for it");
    } else if (!hasLight(scene)) {
        logWarn("the gradient of " + parameter + " is zero, as the scene has no light");
    } else {
        logWarn("no path reached " + parameter + ": its gradient is zero. The camera does not see it, nor what it lights, within the depth and the samples of this pass");
    }
}

void warnOfUnsampledLights(const Options& options, const Scene& scene) {
    const auto shining = std::count_if(scene.lights.begin(), scene.lights.end(), [](const PunctualLight& l) { return meanIntensity(l) > 0; });
    if (options.noLightSampling && shining > 0)
        logWarn("without light sampling (--no-nee) " + std::to_string(shining) + (shining == 1 ? " punctual light is" : " punctual lights are") +
                " left out: no path meets what has no surface");
}

} // namespace cmpg
