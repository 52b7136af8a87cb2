// A scene and a renderer of the library's surface as the options want them.
#include "session/render_session.h"

#include "base/communicator.h"
#include "base/log.h"
#include "imaging/layers_file.h"
#include "library/states.h"
#include "optimize/error_budget.h"
#include "session/guided_session.h"
#include "session/parameter_values.h"
#include "session/ranks.h"

#include <algorithm>
#include <cstdio>

namespace cmpg {
namespace {

v1::Scene load(const Options& options) {
    v1::SceneOptions given{.environment = options.environment, .environmentRotation = options.environmentRotation.value_or(0.0f)};
    for (const std::string& definition : options.define) {
        const std::size_t equals = definition.find('=');
        given.define[definition.substr(0, equals)] = definition.substr(equals + 1);
    }
    v1::Scene scene = v1::Scene::load(options.input, given);
    for (const std::string& warning : scene.warnings())
        logWarn(warning);
    for (const std::string& assignment : options.set)
        applySet(scene.state()->scene, assignment);
    return scene;
}

v1::PathOptions pathOptions(const Options& o, std::uint32_t depth) {
    return {.maxDepth = depth,
            .sampling = o.sampling,
            .pixelSampling = o.pixelSampling.value_or(PixelSampling::Adjoint),
            .roulette = o.roulette,
            .positivize = o.positivize,
            .lightSampling = !o.noLightSampling,
            .memory = o.memory,
            .guideMemory = o.guideMemory,
            .sampler = o.sampler,
            .guide = {.load = o.loadGuide,
                      .keep = !o.saveGuide.empty(),
                      .share = o.guideShare,
                      .rouletteEffort = o.rouletteEffort,
                      .cellRecords = o.cellRecords,
                      .directionShare = o.directionShare,
                      .forgetting = o.forgetting},
            .allFeatures = o.allFeatures};
}

} // namespace

RenderSession::RenderSession(const Options& options, Report& report)
    : scene(load(options)), options_(options), report_(report), record_(options, report) {
    for (const std::uint32_t p : selectParameters(host(), options.param))
        parameters.push_back(host().parameters[p].name);
}

const Scene& RenderSession::host() const { return scene.state()->scene; }
const Parameter& RenderSession::parameter(std::size_t index) const { return host().parameters[host().parameter(parameters[index])]; }

void RenderSession::prepare(const View& view, const std::filesystem::path& folder, std::initializer_list<v1::PassKind> kinds) {
    camera_ = view.camera->name;
    width_ = view.width;
    height_ = view.height;
    device_.emplace(options_.device.empty() ? deviceOfRank() : options_.device);
    requireSameRanks(device_->state()->device, options_);
    const std::uint32_t depth = options_.effectiveDepth(host().maxDepth);
    renderer_.emplace(*device_, scene, v1::RendererOptions{.paths = pathOptions(options_, depth), .parameters = parameters});
    v1::PassOptions pass = plainPass(1);
    pass.train = usesGuide(options_) ? options_.effectiveTrain() : 0;
    pass.layers = !options_.layers.empty();
    renderer_->prepare(kinds, pass);
    const Device& device = device_->state()->device;
    report_.seconds.load = std::max(0.0, loading_.seconds() - device.compileSeconds());
    report_.addDevice(device);
    record_.begin(view, depth, folder);
}

v1::PassOptions RenderSession::plainPass(std::uint32_t spp) const {
    return {.camera = camera_, .width = width_, .height = height_, .spp = spp, .seed = options_.seed, .strict = false};
}

v1::PassOptions RenderSession::pass(std::uint32_t spp) const {
    v1::PassOptions pass = plainPass(spp);
    pass.train = usesGuide(options_) ? options_.effectiveTrain() : 0;
    pass.trainSpp = options_.effectiveTrainSpp();
    pass.batches = options_.effectiveBatches();
    pass.layers = !options_.layers.empty();
    if (options_.errorTarget)
        pass.errorTarget = double(*options_.errorTarget);
    constexpr double kLeast = 1e-6; // what was before may have taken all
    if (options_.timeBudget)
        pass.timeBudget = std::max(kLeast, double(*options_.timeBudget) - report_.elapsed());
    return pass;
}

void RenderSession::add(const v1::PassReport& pass) {
    report_.addStatistics({.guided = pass.depths,
                           .paths = pass.paths,
                           .rays = pass.rays,
                           .dropped = pass.dropped,
                           .repeatedPasses = 0,
                           .refusedSplits = pass.refusedSplits});
    report_.seconds.guide += pass.learningSeconds;
}

void RenderSession::tell(const v1::PassReport& pass) {
    if (!options_.layers.empty() && ranks().isRoot()) {
        writeLayers(options_.layers, pass.layers, pass.guided);
        report_.outputs.emplace_back("layers", options_.layers);
    }
    tellSampling(options_, report_, pass.sampling, pass.roulette, pass.figures);
    if (options_.saveGuide.empty() || !ranks().isRoot())
        return;
    renderer_->saveGuide(options_.saveGuide);
    report_.outputs.emplace_back("guide", options_.saveGuide);
}

ExitStatus RenderSession::conclude(const v1::PassReport& pass, std::optional<std::uint32_t> Options::* samples) {
    report_.spp = pass.spp;
    if (pass.batches == 0)
        return ExitStatus::Done;
    const EstimateError& error = pass.error;
    const bool reached = !options_.errorTarget || error.relative <= double(*options_.errorTarget);
    report_.extra["error"] = {{"relative", error.relative}, {"low", error.low},   {"high", error.high}, {"degrees", error.degrees},
                              {"batches", pass.batches},    {"spp", pass.spp},    {"reached", reached}};
    record_.record([&](Options& o) {
        o.*samples = pass.spp;
        o.batches = pass.batches;
        o.timeBudget.reset();
    });
    if (!options_.quiet)
        textOut(options_) << "  error             " << describe(error) << ", " << pass.spp << " samples per pixel in " << pass.batches << " batches\n";
    if (reached)
        return ExitStatus::Done;
    char target[32];
    std::snprintf(target, sizeof target, "%.3g %%", 100 * double(*options_.errorTarget));
    const bool time = pass.end == BudgetEnd::Time;
    logWarn("the error target of " + std::string(target) + " was not reached: the error is " + describe(error) + " after " + std::to_string(pass.spp) +
            " samples per pixel; " + (time ? "allow more --time-budget" : "allow more samples"));
    return ExitStatus::CheckFailed;
}

void RenderSession::finish(const Image* result) {
    if (ranks().size() > 1)
        report_.extra["ranks"] = trafficReport();
    report_.addDevice(device_->state()->device);
    record_.requireFinite(result);
}

} // namespace cmpg
