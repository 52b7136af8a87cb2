// What stands behind a recovery of the library's surface.
#include "library/recovery_state.h"

#include "base/error.h"
#include "library/ranks.h"
#include "library/recovery_identity.h"
#include "library/targets.h"
#include "optimize/content_identity.h"
#include "optimize/recovery_config.h"

#include <algorithm>
#include <sstream>
#include <utility>

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
    require(options.schedule != Schedule::Exponential || options.finalRate > 0, "final-rate", "above 0 with an exponential schedule");
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

Renderer::State::Capacity capacityFor(const RecoveryOptions& options) {
    const PathOptions& paths = options.paths;
    const bool learns = paths.sampling != Sampling::Bsdf || paths.roulette || paths.guide.keep;
    return {.guiding = learns, .learning = learns, .roulette = paths.roulette, .differences = options.sppDifference > 0};
}

std::shared_ptr<Renderer::State> rendererFor(const std::shared_ptr<Device::State>& device, Scene::State& source, const RecoveryOptions& options) {
    const std::lock_guard lock(mutexOf(*device));
    return checked(device->ranks(), [&] {
        return makeState<Renderer::State>(device, source, RendererOptions{.paths = options.paths, .parameters = options.parameters}, capacityFor(options));
    });
}

} // namespace

Recovery::State::State(std::shared_ptr<Device::State> device, Scene::State& source, const std::vector<Target>& targets, const RecoveryOptions& options)
    : base(rendererFor(device, source, options)), shared(false), steps(options.steps), learns(base->capacity->learning) {
    begin(targets, options, {});
}

Recovery::State::State(std::shared_ptr<Renderer::State> renderer, const std::vector<Target>& targets, RecoveryOptions options, const RecoveryProgress& from)
    : base(std::move(renderer)), shared(true), steps(options.steps) {
    options.paths = base->options.paths;
    options.parameters = base->options.parameters;
    learns = capacityFor(options).learning;
    const Renderer::State::Work work(*base);
    begin(targets, options, from);
}

Recovery::State::~State() {
    const std::lock_guard lock(base->device->mutex);
    run.reset();
}

void Recovery::State::begin(const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from) {
    const std::lock_guard lock(mutexOf(*base->device));
    RecoveryRun::Steps plan = checked(ranks(), [&] { return planOf(targets, options, from); });
    std::string all;
    for (const auto& [name, value] : identity)
        all += name + '\n' + value + '\n';
    agree(ranks(), all, "recovers something else", "it was given another scene, other values, targets or options");
    together(ranks(), [&] {
        base->ensure(cmpg::Renderer::Mode::Reverse, false);
        base->passes->setLearning(learns && !shared);
        run.emplace(*base->renderer, *base->passes, scene(), parameters(), std::move(plan));
    });
    generation = ++base->generation;
}

RecoveryRun::Steps Recovery::State::planOf(const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from) {
    if (!base->capacity)
        throw Error(ErrorKind::Usage, "this renderer makes no recoveries", "it was not made for them", "make it with RendererOptions::recoveries");
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
        plan.wrap = [this, &options](ImageModel& inner) {
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
    for (const std::uint32_t p : parameters())
        sizes.emplace_back(scene().parameters[p].width, scene().parameters[p].height);
    if (from.state)
        goOn(plan, *from.state);
    return plan;
}

Checkpoint::Identity Recovery::State::objective() const {
    Checkpoint::Identity entries;
    std::copy_if(identity.begin(), identity.end(), std::back_inserter(entries), [](const auto& entry) {
        const std::string& name = entry.first;
        return name == "loss" || name.starts_with("the camera") || name.starts_with("filter") || name.starts_with("the target");
    });
    return entries;
}

// Parameters that stay keep their moments; those that are new, have another size or step by another method begin here. So do all where the loss or the
// targets are others, which gradients and curvature are of.
void Recovery::State::goOn(RecoveryRun::Steps& plan, const RecoveryProgress::State& before) const {
    plan.start.step = before.steps;
    const bool same = before.objective == objective();
    for (const std::uint32_t p : parameters()) {
        const cmpg::Parameter& parameter = scene().parameters[p];
        const OptimizerKind method = methodOf(plan.config, parameter.kind);
        const auto found = std::find_if(before.known.begin(), before.known.end(), [&](const RecoveryProgress::State::Known& known) {
            return same && known.parameter == parameter.name && known.method == method && known.size == std::pair(parameter.width, parameter.height);
        });
        if (found != before.known.end()) {
            plan.start.moments.push_back(found->moments);
            continue;
        }
        plan.start.moments.push_back(initialMoments(plan.config.optimizer, parameter));
        plan.start.moments.back().start = before.steps;
    }
}

double Recovery::State::usualPace(double pace) {
    constexpr std::size_t kSteps = 5;
    paces.push_back(pace);
    if (paces.size() > kSteps)
        paces.pop_front();
    std::vector<double> sorted(paces.begin(), paces.end());
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
}

std::size_t Recovery::State::indexOf(const std::string& name) const {
    const auto found = std::find(parameters().begin(), parameters().end(), scene().parameter(name));
    if (found == parameters().end())
        throw Error(ErrorKind::Usage, name + " is not recovered", {}, "name it among the parameters", {"param"});
    return std::size_t(found - parameters().begin());
}

void Recovery::State::requireTarget(std::size_t target) const {
    if (target >= views.size())
        throw Error(ErrorKind::Usage, "there is no target " + std::to_string(target), {}, "targets are numbered from 0 to " + std::to_string(views.size() - 1));
}

void Recovery::State::requirePicture(std::size_t target, std::uint32_t spp) const {
    checked(ranks(), [&] {
        require(spp >= 1 && spp <= kMostSamples, "spp", "from 1 to 16777216");
        requireTarget(target);
    });
}

void Recovery::State::requireGoing() const {
    if (ended())
        throw Error(ErrorKind::Usage, "the recovery has ended: its renderer was put to another use",
                    "another recovery was made of it, it draws otherwise now, or a value changed that it was not made for", "go on from progress()");
}

std::string Recovery::State::names() const {
    std::string all;
    for (const std::uint32_t p : parameters())
        all += (all.empty() ? "" : ", ") + scene().parameters[p].name;
    return all;
}

void Recovery::State::requireSameOnAll(const std::string& what) const {
    checked(ranks(), [&] { requireGoing(); });
    if (ranks().size() == 1)
        return;
    std::ostringstream all;
    all.precision(17);
    const Optimization& now = run->optimization();
    all << what << ' ' << now.state().step << ' ' << now.config().spp << ' ' << now.config().sppGradient << ' ' << now.givenRateFactor();
    for (const std::uint32_t p : parameters())
        all << ' ' << digestOf(scene().parameters[p].values);
    agree(ranks(), all.str(), "is not in the same place of its recovery, or has asked for something else there,",
          "it has made other steps, goes on from another checkpoint, or was given other values, samples or another factor of the rates");
}

void Recovery::State::prepare(bool ahead) {
    base->renderer->setInteraction(base->interaction());
    if (ahead && !std::exchange(prepared, true))
        run->prepareStep();
}

void Recovery::State::setParameters(const std::vector<std::vector<float>>& values) {
    for (std::size_t i = 0; i < parameters().size(); ++i)
        scene().parameters[parameters()[i]].values = values[i]; // also where the device is lost
    for (std::size_t i = 0; i < parameters().size(); ++i)
        run->model().setParameter(parameters()[i], values[i]);
}

std::vector<std::vector<float>> Recovery::State::current() const {
    std::vector<std::vector<float>> values;
    for (const std::uint32_t p : parameters())
        values.push_back(scene().parameters[p].values);
    return values;
}

} // namespace cmpg::v1
