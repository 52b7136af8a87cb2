// Recoveries of the library's surface.
#include <cmpg/recovery.h>

#include "base/error.h"
#include "base/stopwatch.h"
#include "library/ranks.h"
#include "library/recovery_identity.h"
#include "library/renderer_state.h"
#include "library/targets.h"
#include "optimize/batched_model.h"
#include "optimize/content_identity.h"
#include "optimize/gradient_watch.h"
#include "optimize/loaded_target.h"
#include "optimize/recovery_config.h"
#include "optimize/recovery_run.h"
#include "render/saved_guide.h"
#include "scene/parameter_values.h"

#include <algorithm>
#include <cmath>
#include <list>

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
        require(options.batches >= kFewestBatches && options.batches <= kMostBatches, "batches", "from 8 to 64");
        require(options.sppGradient >= options.batches, "spp-gradient", "as many as there are batches under an error target, at least");
    }
    for (const auto& [slot, rate] : options.rates)
        require(rate >= 0 && rate < 1e6f, "rate", "from 0 to 1e6");
    return configOf(options);
}

RecoveryStep stepOf(const StepRecord& record, std::uint32_t step) {
    return {.step = step,
            .loss = record.loss,
            .lossError = record.lossError,
            .regularizer = record.regularizer,
            .rate = record.rate,
            .seconds = record.secondsPrimal + record.secondsGradient + record.secondsUpdate,
            .imageSeconds = record.secondsPrimal,
            .gradientSeconds = record.secondsGradient,
            .updateSeconds = record.secondsUpdate,
            .gradientNorm = record.gradientNorm,
            .dropped = record.dropped};
}

// Error(Input) where there are some, and none can be read.
std::optional<Checkpoint> checkpointIn(const std::filesystem::path& folder, std::vector<std::string>& refused) {
    std::optional<Checkpoint> found = findCheckpoint(folder, refused);
    if (!found && !refused.empty())
        throw Error(ErrorKind::Input, "no checkpoint in '" + folder.string() + "' can be used: " + refused.front(), {}, "begin anew", {"resume"});
    return found;
}

} // namespace

struct RecoveryProgress::State {
    std::uint32_t steps = 0;
    std::vector<std::pair<std::string, Moments>> moments; // by parameter
};

struct Recovery::State {
    std::shared_ptr<Renderer::State> base;
    const bool shared; // the renderer is somebody's, who has other passes made between the steps
    std::uint32_t steps;
    bool learns;
    std::uint32_t freeze; // step from which on the guide stays as it is
    Checkpoint::Identity identity;
    GradientWatch watch;
    std::function<void(std::size_t, const Image&)> showImage;
    std::list<cmpg::Camera> moved; // cameras of targets
    std::vector<View> views;
    std::optional<RecoveryRun> run;
    std::uint64_t generation = 0; // of the renderer that the run is made of
    bool prepared = false;
    std::vector<std::vector<float>> initial; // values of the parameters
    const BatchedModel* batched = nullptr; // where gradients have an error target

    // A recovery with a renderer of its own.
    State(std::shared_ptr<Device::State> device, Scene::State& source, const std::vector<Target>& targets, const RecoveryOptions& options)
        : base(std::make_shared<Renderer::State>(std::move(device), source, RendererOptions{.paths = options.paths, .parameters = options.parameters}, roomFor(options))),
          shared(false), steps(options.steps), learns(base->room->learning) {
        begin(targets, options, {});
    }
    State(std::shared_ptr<Renderer::State> renderer, const std::vector<Target>& targets, RecoveryOptions options, const RecoveryProgress& from)
        : base(std::move(renderer)), shared(true), steps(options.steps) {
        options.paths = base->options.paths;
        options.parameters = base->options.parameters;
        learns = roomFor(options).learning;
        if (!base->room)
            throw Error(ErrorKind::Usage, "this renderer has no room for recoveries", "it was not made for them", "make it with RendererOptions::recoveries");
        const std::lock_guard lock(base->device->mutex);
        base->follow();
        begin(targets, options, from);
    }
    ~State() {
        const std::lock_guard lock(base->device->mutex);
        run.reset();
    }
    State(const State&) = delete;

    static Renderer::State::Room roomFor(const RecoveryOptions& options) {
        const PathOptions& paths = options.paths;
        const bool learns = paths.sampling != Sampling::Bsdf || paths.roulette || paths.guide.keep;
        return {.guiding = learns, .learning = learns, .roulette = paths.roulette, .differences = options.sppDifference > 0};
    }
    void begin(const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from) {
        RecoveryRun::Steps plan{.config = checkedConfig(options), .views = {}};
        if (targets.empty())
            throw Error(ErrorKind::Usage, "a recovery needs a target", {}, "give an image of the scene", {"target"});
        if (parameters().empty())
            throw Error(ErrorKind::Usage, "there is nothing to recover", {}, "name a parameter", {"param"});
        for (const Target& target : targets) {
            plan.config.targets.push_back(targetOf(target, views.size()));
            const Image& image = plan.config.targets.back().image;
            if (target.from)
                moved.push_back(movedCamera(scene(), *target.from));
            views.push_back({target.from ? &moved.back() : &scene().camera(target.camera), image.width, image.height});
        }
        plan.views = views;
        if (options.errorTarget > 0)
            plan.wrap = [&](ImageModel& inner) {
                auto model = std::make_unique<BatchedModel>(
                    inner, SampleBudget{.batches = options.batches, .samples = options.sppGradient / options.batches, .error = options.errorTarget});
                batched = model.get();
                return model;
            };
        freeze = options.freeze > 0 ? options.freeze : ~0u;
        if (!shared)
            plan.freeze = freeze;
        identity = identityOf(options, plan.config, renderConfig(options.paths, scene(), parameters()).maxDepth, names());
        for (auto& entry : contentIdentity(scene(), parameters(), views, plan.config.targets))
            identity.push_back(std::move(entry));
        plan.config.onImage = [this](std::size_t view, const Image& image) {
            if (showImage)
                showImage(view, image);
        };
        initial = current();
        if (from.state)
            goOn(plan, *from.state);
        const std::lock_guard lock(mutex());
        requireSameOnAll();
        together(base->device->ranks(), [&] {
            base->ensure(cmpg::Renderer::Mode::Reverse, false);
            base->passes->setLearning(learns && !shared);
            run.emplace(*base->renderer, *base->passes, scene(), parameters(), std::move(plan));
        });
        generation = ++base->generation;
    }
    // Parameters that stay keep their moments; new ones begin here.
    void goOn(RecoveryRun::Steps& plan, const RecoveryProgress::State& before) {
        plan.start.step = before.steps;
        for (const std::uint32_t p : parameters()) {
            const cmpg::Parameter& parameter = scene().parameters[p];
            const auto found = std::find_if(before.moments.begin(), before.moments.end(), [&](const auto& known) { return known.first == parameter.name; });
            if (found != before.moments.end()) {
                plan.start.moments.push_back(found->second);
                continue;
            }
            plan.start.moments.push_back(initialMoments(plan.config.optimizer, parameter));
            plan.start.moments.back().start = before.steps;
        }
    }

    cmpg::Scene& scene() const { return base->scene; }
    const std::vector<std::uint32_t>& parameters() const { return base->parameters; }
    Communicator& ranks() const { return base->device->ranks(); }
    std::recursive_mutex& mutex() const { return base->device->mutex; }
    Optimization& optimization() { return run->optimization(); }

    std::size_t indexOf(const std::string& name) const {
        const auto found = std::find(parameters().begin(), parameters().end(), scene().parameter(name));
        if (found == parameters().end())
            throw Error(ErrorKind::Usage, name + " is not recovered", {}, "name it among the parameters", {"param"});
        return std::size_t(found - parameters().begin());
    }
    void requireTarget(std::size_t target) {
        if (target >= views.size())
            throw Error(ErrorKind::Usage, "there is no target " + std::to_string(target), {}, "targets are numbered from 0 to " + std::to_string(views.size() - 1));
    }
    bool ended() const { return generation != base->generation; }
    // Takes over what others have changed.
    void requireGoing() {
        base->follow();
        if (ended())
            throw Error(ErrorKind::Usage, "the recovery has ended: its renderer was put to another use",
                        "another recovery was made of it, it draws otherwise now, or a value changed that it was not made for", "go on from progress()");
    }
    std::string names() const {
        std::string all;
        for (const std::uint32_t p : parameters())
            all += (all.empty() ? "" : ", ") + scene().parameters[p].name;
        return all;
    }
    void requireSameOnAll() const {
        std::string all;
        for (const auto& [name, value] : identity)
            all += name + '\n' + value + '\n';
        if (const int other = firstOther(ranks(), all))
            throw Error(ErrorKind::Usage, "rank " + std::to_string(other) + " recovers something else than rank 0",
                        "it was given another scene, other values, targets or options", "give all ranks the same");
    }
    // `ahead`: kernels are made while others run already, which nothing can interrupt.
    void prepare(bool ahead) {
        base->renderer->setInteraction(base->interaction());
        if (ahead && !std::exchange(prepared, true))
            run->prepareStep();
    }
    // Between steps nothing is learned from what others have a renderer make.
    template <class Work> void learning(Work&& work) {
        if (!shared)
            return work();
        const bool learnsNow = learns && optimization().state().step < freeze;
        base->passes->setLearning(learnsNow);
        try {
            work();
        } catch (...) {
            base->passes->setLearning(false);
            throw;
        }
        base->passes->setLearning(false);
        base->fresh &= !learnsNow;
    }
    void setParameters(const std::vector<std::vector<float>>& values) {
        for (std::size_t i = 0; i < parameters().size(); ++i)
            scene().parameters[parameters()[i]].values = values[i]; // also where the device is lost
        for (std::size_t i = 0; i < parameters().size(); ++i)
            run->model().setParameter(parameters()[i], values[i]);
    }
    std::vector<std::vector<float>> current() const {
        std::vector<std::vector<float>> values;
        for (const std::uint32_t p : parameters())
            values.push_back(scene().parameters[p].values);
        return values;
    }
    std::string madeWith() const { return base->device->info.name + ", " + base->device->info.driver; }
};

Recovery::Recovery(const Device& device, const Scene& scene, const std::vector<Target>& targets, const RecoveryOptions& options)
    : state_(std::make_shared<State>(device.state(), *scene.state(), targets, options)) {}

Recovery::Recovery(const Renderer& renderer, const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from)
    : state_(std::make_shared<State>(renderer.state(), targets, options, from)) {}

bool Recovery::ended() const {
    const std::lock_guard lock(state_->mutex());
    return state_->ended();
}

RecoveryProgress Recovery::progress() const {
    const std::lock_guard lock(state_->mutex());
    const OptimizeState& now = state_->optimization().state();
    auto progress = std::make_shared<RecoveryProgress::State>();
    progress->steps = now.step;
    for (std::size_t i = 0; i < now.moments.size(); ++i)
        progress->moments.emplace_back(state_->scene().parameters[state_->parameters()[i]].name, now.moments[i]);
    return {std::move(progress)};
}

RecoveryStep Recovery::step() {
    State& s = *state_;
    const std::lock_guard lock(s.mutex());
    s.requireGoing();
    const Stopwatch watch;
    StepReport report;
    const Optimization& optimization = s.optimization();
    const double work = optimization.nextWork();
    try {
        together(s.ranks(), [&] {
            s.learning([&] {
                s.prepare(!s.shared); // who looks on may want to end the step
                report = s.optimization().step();
            });
        });
    } catch (...) {
        s.base->abandon();
        throw;
    }
    s.base->giveBack();
    if (firstOther(s.ranks(), std::string_view(reinterpret_cast<const char*>(&report.loss), sizeof report.loss)))
        throw Error(ErrorKind::Numerical, "ranks have computed different losses", "a processor or a driver computes differently on one of the machines",
                    "start the ranks on machines of one kind");
    RecoveryStep step = stepOf(recordOf(report), report.step);
    step.seconds = watch.seconds();
    step.concentration = report.concentration;
    step.paths = report.samples;
    step.nextSeconds = step.seconds * optimization.nextWork() / work;
    step.warnings = s.watch.observe(report);
    return step;
}

void Recovery::prepare() {
    State& s = *state_;
    const std::lock_guard lock(s.mutex());
    s.requireGoing();
    together(s.ranks(), [&] { s.learning([&] { s.prepare(true); }); });
}

std::vector<RecoveryStep> Recovery::history() const {
    const std::lock_guard lock(state_->mutex());
    std::vector<RecoveryStep> steps;
    for (const StepRecord& record : state_->run->optimization().state().history)
        steps.push_back(stepOf(record, std::uint32_t(steps.size())));
    return steps;
}

std::uint32_t Recovery::steps() const {
    const std::lock_guard lock(state_->mutex());
    return state_->run->optimization().state().step;
}

bool Recovery::done() const { return steps() >= state_->steps; }

std::vector<ParameterInfo> Recovery::parameters() const {
    std::vector<ParameterInfo> infos;
    for (const std::uint32_t p : state_->parameters())
        infos.push_back(describe(state_->scene().parameters[p]));
    return infos;
}

std::vector<float> Recovery::values(const std::string& parameter) const {
    const std::lock_guard lock(state_->mutex());
    return state_->scene().parameters[state_->parameters()[state_->indexOf(parameter)]].values;
}

std::vector<double> Recovery::gradient(const std::string& parameter) const {
    const std::lock_guard lock(state_->mutex());
    const std::size_t index = state_->indexOf(parameter);
    const auto& gradients = state_->run->optimization().gradients();
    return gradients.empty() ? std::vector<double>(state_->scene().parameters[state_->parameters()[index]].entries()) : gradients[index];
}

PassReport Recovery::report() const {
    State& s = *state_;
    const std::lock_guard lock(s.mutex());
    PassReport report = s.base->totals(cmpg::Renderer::Mode::Reverse);
    report.width = s.views.front().width;
    report.height = s.views.front().height;
    report.spp = s.optimization().config().spp;
    return report;
}

Image Recovery::target(std::size_t target) const {
    const std::lock_guard lock(state_->mutex());
    state_->requireTarget(target);
    return LoadedTarget(state_->run->optimization().config().targets[target])->image;
}

Image Recovery::image(std::size_t target, std::uint32_t spp, bool initial) {
    require(spp >= 1 && spp <= kMostSamples, "spp", "from 1 to 16777216");
    State& s = *state_;
    const std::lock_guard lock(s.mutex());
    s.requireTarget(target);
    s.requireGoing();
    s.base->renderer->setInteraction(s.base->interaction());
    const auto render = [&] { return together(s.ranks(), [&] { return s.optimization().render(target, spp); }); };
    if (!initial)
        return render();
    const std::vector<std::vector<float>> now = s.current();
    s.setParameters(s.initial);
    try {
        Image image = render();
        s.setParameters(now);
        return image;
    } catch (...) {
        s.setParameters(now);
        throw;
    }
}

void Recovery::image(Film& film, std::size_t target, std::uint32_t spp, PassReport* report) {
    require(spp >= 1 && spp <= kMostSamples, "spp", "from 1 to 16777216");
    State& s = *state_;
    const std::lock_guard lock(s.mutex());
    s.requireTarget(target);
    s.requireGoing();
    const View& view = s.views[target];
    const PassKey key = pictureKey(s.optimization().config().seed, target);
    s.base->expose(cmpg::Renderer::Mode::Render, film, view, {.spp = spp, .strict = false}, {}, report,
                   [&](std::uint32_t samples, cmpg::Film& sums) { s.base->passes->render(view, samples, key, sums); });
}

void Recovery::setSamples(std::uint32_t spp, std::uint32_t sppGradient) {
    require(spp >= 1 && spp <= kMostSamples, "spp", "from 1 to 16777216");
    require(sppGradient >= 1 && sppGradient <= kMostSamples, "spp-gradient", "from 1 to 16777216");
    const std::lock_guard lock(state_->mutex());
    state_->optimization().setSamples(spp, sppGradient);
}

void Recovery::setRateFactor(double factor) {
    require(factor >= 0 && factor <= 1e6, "rate", "a factor from 0 to 1e6");
    const std::lock_guard lock(state_->mutex());
    state_->optimization().setRateFactor(factor);
}

void Recovery::apply(Scene& scene) const {
    std::vector<std::pair<std::string, std::vector<float>>> values;
    for (const ParameterInfo& info : parameters())
        values.emplace_back(info.name, this->values(info.name));
    for (const auto& [name, entries] : values)
        scene.set(name, entries);
}

std::uint64_t Recovery::save(const std::filesystem::path& folder, const std::string& note) const {
    const std::lock_guard lock(state_->mutex());
    RecoveryRun& run = *state_->run;
    state_->requireGoing();
    if (!state_->ranks().isRoot())
        return 0;
    const std::vector<FileSection> sections = checkpointSections(run.optimization(), run.model(), state_->identity, note, state_->madeWith());
    writeCheckpointFile(folder, sections);
    std::uint64_t bytes = 0;
    for (const FileSection& section : sections)
        bytes += section.bytes.size();
    return bytes;
}

bool Recovery::resume(const std::filesystem::path& folder, std::vector<Warning>* warnings) {
    std::vector<std::string> refused;
    const std::optional<Checkpoint> found = checkpointIn(folder, refused);
    if (!found)
        return false;
    requireSame(found->identity, state_->identity, folder);
    const std::lock_guard lock(state_->mutex());
    state_->requireGoing();
    cmpg::resume(*found, state_->optimization(), state_->run->model());
    state_->base->giveBack();
    if (!warnings)
        return true;
    for (const std::string& reason : refused)
        warnings->push_back({"checkpoint_refused", "a checkpoint is left aside for an older one: " + reason});
    if (const std::string now = state_->madeWith(); found->madeWith != now)
        warnings->push_back({"other_device", "the run was on " + found->madeWith + " and continues on " + now + ": rounding may differ from here on"});
    return true;
}

std::optional<std::string> Recovery::note(const std::filesystem::path& folder) {
    std::vector<std::string> refused;
    std::optional<Checkpoint> found = checkpointIn(folder, refused);
    return found ? std::optional(std::move(found->config)) : std::nullopt;
}

GradientErrors Recovery::errors() const {
    const std::lock_guard lock(state_->mutex());
    return state_->batched ? state_->batched->tally() : GradientErrors{};
}

void Recovery::saveGuide(const std::filesystem::path& file) const {
    const std::lock_guard lock(state_->mutex());
    const Renderer::State& base = *state_->base;
    if (!base.renderer || !base.renderer->hasGuide())
        throw Error(ErrorKind::Usage, "there is no guide to save: directions are drawn from the materials alone", {}, "have one kept, or choose another sampling",
                    {"save-guide", "sampling"});
    if (state_->ranks().isRoot())
        writeGuide(file, base.scene, base.parameters, *base.renderer, *base.passes);
}

void Recovery::onSubmission(std::function<void()> call, double seconds) {
    require(seconds >= 0.001 && seconds <= 10, "seconds of a submission", "from 0.001 to 10");
    const std::lock_guard lock(state_->mutex());
    state_->base->call = std::move(call);
    state_->base->callSeconds = seconds;
}

void Recovery::onImage(std::function<void(std::size_t, const Image&)> call) {
    const std::lock_guard lock(state_->mutex());
    state_->showImage = std::move(call);
}

} // namespace cmpg::v1
