// Recoveries of the library's surface.
#include <cmpg/recovery.h>

#include "base/error.h"
#include "base/stopwatch.h"
#include "library/states.h"
#include "optimize/batched_model.h"
#include "optimize/content_identity.h"
#include "optimize/gradient_watch.h"
#include "optimize/recovery_config.h"
#include "optimize/recovery_run.h"
#include "render/saved_guide.h"
#include "scene/file_io.h"
#include "scene/parameter_values.h"

#include <algorithm>
#include <cmath>

namespace cmpg::v1 {
namespace {

OptimizeConfig checkedConfig(const RecoveryOptions& options) {
    constexpr std::uint32_t kMostSteps = 10'000'000;
    const auto within = [](float value, float highest) { return value >= 0 && value <= highest; };
    require(options.steps >= 1 && options.steps <= kMostSteps, "steps", "from 1 to 10000000");
    require(options.spp >= 1 && options.spp <= kMostSamples, "spp", "from 1 to 16777216");
    require(options.sppGradient >= 1 && options.sppGradient <= kMostSamples, "spp-gradient", "from 1 to 16777216");
    require(options.sppDifference != 1 && options.sppDifference <= kMostSamples, "spp-difference",
            "0, or from 2 to 16777216: an image has two halves");
    require(within(options.finalRate, 1), "final-rate", "from 0 to 1");
    require(within(options.prior, 1e6f), "prior", "from 0 to 1e6");
    require(within(options.totalVariation, 1e6f), "total-variation", "from 0 to 1e6");
    if (options.errorTarget != 0) {
        require(options.errorTarget >= 1e-6 && options.errorTarget <= 100, "error-target", "from 1e-6 to 100, or 0");
        require(options.sppGradient >= kFewestBatches, "spp-gradient", "at least 8 under an error target");
    }
    for (const auto& [slot, rate] : options.rates)
        require(rate >= 0 && rate < 1e6f, "rate", "from 0 to 1e6");
    return configOf(options);
}

cmpg::Target targetOf(const Target& target, std::size_t number) {
    const std::string name = "target " + std::to_string(number);
    const Image& image = target.image;
    if (image.channels != 3 || image.width < 1 || image.height < 1 || image.values.size() != image.pixels() * 3)
        throw Error(ErrorKind::Usage, name + " is no image of 3 channels, one value per pixel and channel");
    if (!target.mask.empty() && target.mask.size() != image.pixels())
        throw Error(ErrorKind::Usage,
                    "the mask of " + name + " has " + std::to_string(target.mask.size()) + " weights for " + std::to_string(image.pixels()) + " pixels",
                    {}, "give one weight per pixel", {"mask"});
    cmpg::Target result{.name = name, .image = image, .mask = target.mask};
    for (const float weight : result.mask)
        if (!(weight >= 0 && weight <= 1))
            throw Error(ErrorKind::Usage, "the mask of " + name + " has weights out of [0, 1]", {}, "scale it", {"mask"});
    for (std::size_t p = 0; p < image.pixels(); ++p) {
        const float* pixel = image.values.data() + 3 * p;
        if (std::isfinite(pixel[0]) && std::isfinite(pixel[1]) && std::isfinite(pixel[2]))
            continue;
        if (result.mask.empty())
            result.mask.assign(image.pixels(), 1.f);
        result.mask[p] = 0;
        ++result.invalid;
    }
    if (!result.mask.empty() && std::all_of(result.mask.begin(), result.mask.end(), [](float w) { return w == 0; }))
        throw Error(ErrorKind::Input, "no pixel of " + name + " has a weight", "the mask is 0 or values are not finite everywhere",
                    "check mask and image", {"mask"});
    return result;
}

// What bears on the results, by name.
Checkpoint::Identity identityOf(const RecoveryOptions& o, const OptimizeConfig& config, const RenderConfig& render) {
    Checkpoint::Identity identity{{"interface", "1"}};
    const auto add = [&](const std::string& name, double value) {
        char text[40];
        std::snprintf(text, sizeof text, "%.17g", value);
        identity.emplace_back(name, text);
    };
    add("spp", config.spp);
    add("spp-gradient", config.sppGradient);
    add("spp-difference", config.sppDifference);
    identity.emplace_back("seed", std::to_string(config.seed));
    add("loss", double(config.loss));
    add("optimizer", double(config.optimizer.kind));
    for (std::size_t kind = 0; kind < kSlotKinds; ++kind) {
        const bool lobe = kind >= kCommonSlots && kind < kMaterialSlots; // runs without a rate for it are as they were before there was such a slot
        if (lobe && config.optimizer.rates[kind] < 0)
            continue;
        add(std::string("rate of ") + slotName(SlotKind(kind)), double(config.optimizer.rates[kind]));
    }
    add("schedule", double(config.optimizer.schedule));
    if (config.optimizer.schedule != Schedule::Constant) { // else steps may be added
        add("steps", config.steps);
        add("final-rate", double(config.optimizer.finalFactor));
    }
    add("total-variation", config.totalVariation);
    add("prior", config.prior);
    add("views-per-step", config.viewsPerStep);
    add("warm-up", config.warmUp);
    add("freeze", o.freeze);
    add("max-depth", render.maxDepth);
    add("sampling", double(o.paths.sampling));
    add("pixel-sampling", double(o.paths.pixelSampling));
    add("roulette", o.paths.roulette);
    add("positivize", o.paths.positivize);
    add("no-nee", !o.paths.lightSampling);
    add("guide-memory", double(o.paths.guideMemory));
    // What was not there at first is named where it is no default.
    const PathOptions& paths = o.paths;
    const PathOptions usual;
    const auto addUnusual = [&](const std::string& name, double value, double initial) {
        if (value != initial)
            add(name, value);
    };
    addUnusual("error-target", o.errorTarget, 0);
    addUnusual("sampler", double(paths.sampler), double(usual.sampler));
    addUnusual("guide-share", double(paths.guide.share), double(usual.guide.share));
    addUnusual("roulette-effort", double(paths.guide.rouletteEffort), double(usual.guide.rouletteEffort));
    addUnusual("cell-records", paths.guide.cellRecords, usual.guide.cellRecords);
    addUnusual("direction-share", paths.guide.directionShare, usual.guide.directionShare);
    addUnusual("forgetting", paths.guide.forgetting, usual.guide.forgetting);
    addUnusual("save-guide", paths.guide.keep, usual.guide.keep);
    if (!paths.guide.load.empty())
        identity.emplace_back("the guide that was loaded", digestOf(readFile(paths.guide.load)));
    return identity;
}

// The first entry in which two recoveries differ; empty: none.
std::string differenceOf(const Checkpoint::Identity& a, const Checkpoint::Identity& b) {
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i >= a.size() || i >= b.size())
            return (i < a.size() ? a : b)[i].first;
        if (a[i] != b[i])
            return a[i].first;
    }
    return {};
}

} // namespace

Target Target::load(const std::filesystem::path& file, const std::string& camera, const std::filesystem::path& mask, float exposure) {
    cmpg::Target read = loadTarget(file, {.mask = mask, .exposure = exposure});
    return {camera, std::move(read.image), std::move(read.mask)};
}

struct Recovery::State {
    std::shared_ptr<Device::State> device;
    std::vector<std::uint32_t> parameters;
    std::vector<std::uint64_t> revisions; // of the scene it was made of
    cmpg::Scene scene;
    std::uint32_t steps;
    Checkpoint::Identity identity;
    GradientWatch watch;
    std::function<void()> call;
    std::optional<RecoveryRun> run;
    bool prepared = false;
    const BatchedModel* batched = nullptr; // where gradients have an error target

    State(std::shared_ptr<Device::State> d, Scene::State& source, const std::vector<Target>& targets, const RecoveryOptions& options)
        : device(std::move(d)), scene(copyOf(source, options.parameters, parameters, revisions)), steps(options.steps) {
        RecoveryRun::Steps plan{.config = checkedConfig(options), .views = {}};
        if (targets.empty())
            throw Error(ErrorKind::Usage, "a recovery needs a target", {}, "give an image of the scene", {"target"});
        if (parameters.empty())
            throw Error(ErrorKind::Usage, "there is nothing to recover", {}, "name a parameter", {"param"});
        for (const Target& target : targets) {
            plan.config.targets.push_back(targetOf(target, plan.views.size()));
            plan.views.push_back({&scene.camera(target.camera), target.image.width, target.image.height});
        }
        RenderConfig config = renderConfig(options.paths, scene, parameters);
        plan.learn = options.paths.sampling != Sampling::Bsdf || options.paths.roulette || options.paths.guide.keep;
        if (options.errorTarget > 0)
            plan.wrap = [&](ImageModel& inner) {
                auto model = std::make_unique<BatchedModel>(
                    inner, SampleBudget{.batches = kFewestBatches, .samples = options.sppGradient / kFewestBatches, .error = options.errorTarget});
                batched = model.get();
                return model;
            };
        plan.freeze = options.freeze > 0 ? options.freeze : ~0u;
        config.guiding = config.learning = plan.learn;
        config.roulette = options.paths.roulette;
        config.differences = options.sppDifference > 0;
        identity = identityOf(options, plan.config, config);
        for (auto& entry : contentIdentity(scene, parameters, plan.views, plan.config.targets))
            identity.push_back(std::move(entry));
        const std::lock_guard lock(device->mutex);
        run.emplace(device->device, scene, config,
                    guidedOptions(options.paths));
        if (plan.learn && !options.paths.guide.load.empty())
            run->passes().load(readGuide(options.paths.guide.load, scene, &parameters));
        run->begin(std::move(plan));
    }
    ~State() {
        const std::lock_guard lock(device->mutex);
        run.reset();
    }
    State(const State&) = delete;

    std::size_t indexOf(const std::string& name) const {
        const auto found = std::find(parameters.begin(), parameters.end(), scene.parameter(name));
        if (found == parameters.end())
            throw Error(ErrorKind::Usage, name + " is not recovered", {}, "name it among the parameters", {"param"});
        return std::size_t(found - parameters.begin());
    }
    void abandonStep() {
        try {
            if (run->renderer().hasGuide())
                run->passes().abandonStep();
        } catch (const Error&) { // a device that is lost keeps nothing of the step either
        }
    }
    std::string madeWith() const { return device->info.name + ", " + device->info.driver; }
};

Recovery::Recovery(const Device& device, const Scene& scene, const std::vector<Target>& targets, const RecoveryOptions& options)
    : state_(std::make_shared<State>(device.state(), *scene.state(), targets, options)) {}

RecoveryStep Recovery::step() {
    State& s = *state_;
    const std::lock_guard lock(s.device->mutex);
    const Stopwatch watch;
    StepReport report;
    s.run->renderer().setInteraction(interactionOf(s.call));
    try {
        if (!std::exchange(s.prepared, true))
            s.run->prepareStep();
        report = s.run->optimization().step();
    } catch (...) {
        s.abandonStep();
        throw;
    }
    const StepRecord record = recordOf(report);
    RecoveryStep step{.step = report.step,
                      .loss = record.loss,
                      .lossError = record.lossError,
                      .regularizer = record.regularizer,
                      .rate = record.rate,
                      .seconds = watch.seconds(),
                      .gradientNorm = record.gradientNorm,
                      .dropped = record.dropped};
    for (const GradientWatch::Finding& finding : s.watch.observe(report))
        step.warnings.push_back(finding.text);
    return step;
}

std::uint32_t Recovery::steps() const {
    const std::lock_guard lock(state_->device->mutex);
    return state_->run->optimization().state().step;
}

bool Recovery::done() const { return steps() >= state_->steps; }

std::vector<ParameterInfo> Recovery::parameters() const {
    std::vector<ParameterInfo> infos;
    for (const std::uint32_t p : state_->parameters)
        infos.push_back(describe(state_->scene.parameters[p]));
    return infos;
}

std::vector<float> Recovery::values(const std::string& parameter) const {
    const std::lock_guard lock(state_->device->mutex);
    return state_->scene.parameters[state_->parameters[state_->indexOf(parameter)]].values;
}

std::vector<double> Recovery::gradient(const std::string& parameter) const {
    const std::lock_guard lock(state_->device->mutex);
    const std::size_t index = state_->indexOf(parameter);
    const auto& gradients = state_->run->optimization().gradients();
    return gradients.empty() ? std::vector<double>(state_->scene.parameters[state_->parameters[index]].entries()) : gradients[index];
}

Image Recovery::image(std::size_t target, std::uint32_t spp) {
    require(spp >= 1 && spp <= kMostSamples, "spp", "from 1 to 16777216");
    const std::lock_guard lock(state_->device->mutex);
    if (target >= state_->run->model().views())
        throw Error(ErrorKind::Usage, "there is no target " + std::to_string(target), {},
                    "targets are numbered from 0 to " + std::to_string(state_->run->model().views() - 1));
    state_->run->renderer().setInteraction(interactionOf(state_->call));
    return state_->run->optimization().render(target, spp);
}

void Recovery::apply(Scene& scene) const {
    std::vector<std::pair<std::string, std::vector<float>>> values;
    for (const ParameterInfo& info : parameters())
        values.emplace_back(info.name, this->values(info.name));
    for (const auto& [name, entries] : values)
        scene.set(name, entries);
}

void Recovery::save(const std::filesystem::path& folder) const {
    const std::lock_guard lock(state_->device->mutex);
    RecoveryRun& run = *state_->run;
    writeCheckpointFile(folder, checkpointSections(run.optimization(), run.model(), state_->identity, {}, state_->madeWith()));
}

bool Recovery::resume(const std::filesystem::path& folder) {
    std::vector<std::string> refused;
    const std::optional<Checkpoint> found = findCheckpoint(folder, refused);
    if (!found && !refused.empty())
        throw Error(ErrorKind::Input, "no checkpoint in '" + folder.string() + "' can be used: " + refused.front(), {}, "begin anew");
    if (!found)
        return false;
    if (const std::string difference = differenceOf(found->identity, state_->identity); !difference.empty())
        throw Error(ErrorKind::Input, "the recovery in '" + folder.string() + "' is another one: " + difference + " differs",
                    "its result would be neither this one's nor that one's", "give what it was made with, or begin anew");
    const std::lock_guard lock(state_->device->mutex);
    cmpg::resume(*found, state_->run->optimization(), state_->run->model());
    return true;
}

GradientErrors Recovery::errors() const {
    const std::lock_guard lock(state_->device->mutex);
    return state_->batched ? state_->batched->tally() : GradientErrors{};
}

void Recovery::saveGuide(const std::filesystem::path& file) const {
    const std::lock_guard lock(state_->device->mutex);
    const RecoveryRun& run = *state_->run;
    if (!run.renderer().hasGuide())
        throw Error(ErrorKind::Usage, "there is no guide to save: directions are drawn from the materials alone", {}, "have one kept, or choose another sampling",
                    {"save-guide", "sampling"});
    writeGuide(file, state_->scene, state_->parameters, run.renderer(), run.passes());
}

void Recovery::onSubmission(std::function<void()> call) {
    const std::lock_guard lock(state_->device->mutex);
    state_->call = std::move(call);
}

} // namespace cmpg::v1
