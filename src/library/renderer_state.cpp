// What stands behind a renderer of the library's surface.
#include "library/renderer_state.h"

#include "base/error.h"
#include "optimize/content_identity.h"
#include "render/saved_guide.h"
#include "scene/image_size.h"

#include <algorithm>
#include <optional>
#include <sstream>
#include <tuple>

namespace cmpg::v1 {
namespace {

std::optional<std::uint32_t> given(int edge) { return edge > 0 ? std::optional(std::uint32_t(edge)) : std::nullopt; }
PassKind kindOf(cmpg::Renderer::Mode mode) {
    return mode == cmpg::Renderer::Mode::Forward ? PassKind::Forward : mode == cmpg::Renderer::Mode::Reverse ? PassKind::Backward : PassKind::Render;
}
bool hasBudget(const PassOptions& pass) { return pass.errorTarget > 0 || pass.timeBudget > 0; }

} // namespace

cmpg::Renderer::Mode modeOf(PassKind kind) {
    return kind == PassKind::Render ? cmpg::Renderer::Mode::Render : kind == PassKind::Forward ? cmpg::Renderer::Mode::Forward : cmpg::Renderer::Mode::Reverse;
}

std::uint32_t samplesOf(const PassOptions& pass) { return pass.spp > 0 ? pass.spp : hasBudget(pass) ? kMostBudgeted : 64; }
std::uint32_t batchesOf(const PassOptions& pass) { return pass.batches > 0 ? pass.batches : hasBudget(pass) ? kFewestBatches : 0; }

void requireValid(const PassOptions& pass) {
    require(pass.spp <= kMostSamples, "spp", "from 1 to 16777216, or 0");
    require(pass.trainSpp <= kMostSamples, "train-spp", "at most 16777216");
    require(pass.train <= 100000, "train", "at most 100000 passes");
    require(pass.width >= 0 && pass.width <= kMostEdge, "width", "from 1 to 32768, or 0");
    require(pass.height >= 0 && pass.height <= kMostEdge, "height", "from 1 to 32768, or 0");
    require(pass.errorTarget == 0 || (pass.errorTarget >= 1e-6 && pass.errorTarget <= 100), "error-target", "from 1e-6 to 100, or 0");
    require(pass.timeBudget >= 0 && pass.timeBudget <= 1e7, "time-budget", "from 0 to 1e7 seconds");
    if (pass.frozen && pass.train > 0)
        throw Error(ErrorKind::Usage, "a frozen pass draws from no guide", "its random numbers are those of an image without one",
                    "leave learning passes away", {"train"});
    const std::uint32_t batches = batchesOf(pass), samples = samplesOf(pass);
    if (batches == 0)
        return;
    require(batches >= kFewestBatches && batches <= kMostBatches, "batches", "from 8 to 64");
    require(samples >= batches, "spp", "as many as there are batches, at least");
    require(hasBudget(pass) || samples % batches == 0, "spp", "a multiple of the batches");
    if (pass.layers || pass.frozen)
        throw Error(ErrorKind::Usage, pass.layers ? "layers are of passes that are not divided into batches" : "a frozen pass is not divided into batches", {},
                    "leave batches, error target and time budget away", {"batches", "error-target", "time-budget"});
}

Renderer::State::State(std::shared_ptr<Device::State> d, std::shared_ptr<Scene::State> s, const RendererOptions& o)
    : device(std::move(d)), source(std::move(s)), options(o), scene(copyOf(*source, o.parameters, parameters, revisions)) {
    renderConfig(options.paths, scene, parameters); // throws
    const PathOptions& paths = options.paths;
    if (options.recoveries)
        capacity = Capacity{true, paths.sampling != Sampling::Bsdf || paths.roulette || paths.guide.keep, paths.roulette, !parameters.empty()};
}

Renderer::State::State(std::shared_ptr<Device::State> d, Scene::State& s, const RendererOptions& o, const Capacity& c)
    : device(std::move(d)), capacity(c), options(o), scene(copyOf(s, o.parameters, parameters, revisions)) {
    renderConfig(options.paths, scene, parameters); // throws
}

Renderer::State::~State() {
    const std::lock_guard lock(device->mutex);
    drop();
}

void Renderer::State::drop() {
    passes.reset();
    renderer.reset();
    guided = roulette = false;
    trained = 0;
    ++generation;
}

GuidedOptions Renderer::State::drawing(bool roulettePays) const {
    GuidedOptions drawn = guidedOptions(options.paths);
    drawn.roulette = roulettePays;
    return drawn;
}

Renderer::State::Capacity Renderer::State::needsOf(Mode mode, bool learn) const {
    if (capacity)
        return *capacity;
    const PathOptions& paths = options.paths;
    const bool wantsRoulette = paths.roulette && mode == Mode::Reverse;
    const bool wanted = (learn || !paths.guide.load.empty()) && (paths.sampling != Sampling::Bsdf || wantsRoulette || paths.guide.keep);
    return {.guiding = wanted, .roulette = wanted && wantsRoulette};
}

RenderConfig Renderer::State::configOf(const Capacity& needs) const {
    RenderConfig config = renderConfig(options.paths, scene, parameters);
    config.ranks = &device->ranks();
    config.guiding = needs.guiding;
    config.learning = needs.learning;
    config.roulette = needs.roulette;
    config.differences = needs.differences;
    return config;
}

void Renderer::State::make(const Capacity& needs, bool roulettePays, const std::vector<std::uint32_t>* ofGuide) {
    drop();
    renderer = std::make_unique<cmpg::Renderer>(device->device, scene, configOf(needs));
    passes = std::make_unique<GuidedPasses>(*renderer, drawing(roulettePays));
    if (needs.guiding && !options.paths.guide.load.empty())
        passes->load(readGuide(options.paths.guide.load, scene, ofGuide));
    guided = needs.guiding;
    roulette = roulettePays;
    fresh = true;
}

void Renderer::State::ensure(Mode mode, bool learn, bool anew) {
    const PathOptions& paths = options.paths;
    if (capacity) {
        if (!renderer)
            make(*capacity, paths.roulette, parameters.empty() ? nullptr : &parameters);
        else if (learn && anew && !fresh)
            drawAnew(false);
        return;
    }
    const Capacity needs = needsOf(mode, learn);
    if (renderer && !(learn && anew && !fresh) && (!needs.guiding || (guided && (roulette || !needs.roulette))))
        return;
    make(needs, paths.roulette && mode == Mode::Reverse, mode == Mode::Render ? nullptr : &parameters); // an image needs no derivatives
}

std::unique_ptr<cmpg::Renderer> Renderer::State::makeDiffering() {
    auto differing = std::make_unique<cmpg::Renderer>(device->device, scene, configOf({.differences = true}));
    differing->setInteraction(interaction());
    return differing;
}

Footprint Renderer::State::footprint(std::span<const PassKind> kinds, bool learn) const {
    const bool reverse = std::find(kinds.begin(), kinds.end(), PassKind::Backward) != kinds.end();
    const Capacity needs = needsOf(reverse ? Mode::Reverse : Mode::Render, learn);
    cmpg::Scene copy = scene;
    const auto before = device->device.memory().buffers;
    cmpg::Renderer aside(device->device, copy, configOf(needs));
    PassPlan plan;
    if (needs.guiding)
        plan = {.method = {options.paths.sampling == Sampling::Bsdf ? Sampling::Bsdf : Sampling::Conditional, needs.roulette}, .record = true};
    Footprint found;
    found.features = aside.describeFeatures();
    std::vector<Mode> modes;
    for (const PassKind kind : kinds)
        modes.push_back(modeOf(kind));
    for (KernelSize& kernel : aside.allocate(modes, plan))
        found.kernels.push_back({kindOf(kernel.mode), std::move(kernel.kernel), kernel.specialisedBytes, kernel.moduleBytes});
    for (const auto& [name, bytes] : device->device.memory().buffers) {
        const auto was = before.find(name);
        if (const std::uint64_t own = bytes - (was == before.end() ? 0 : was->second))
            found.buffers[name] = own;
    }
    return found;
}

void Renderer::State::drawAnew(bool kept) {
    ++generation;
    if (!renderer)
        return;
    const bool learned = renderer->hasGuide() && !renderer->guide().empty();
    std::optional<LoadedGuide> guide;
    if (learned && kept) {
        guide = LoadedGuide{renderer->guide(), passes->guideContext()};
    } else if (learned) {
        const SdTree& tree = renderer->guide();
        renderer->setGuide(SdTree(tree.lower(), tree.upper(), tree.config()));
    }
    passes = std::make_unique<GuidedPasses>(*renderer, drawing(roulette));
    if (guide)
        passes->load(std::move(*guide));
    if (kept)
        return;
    trained = 0;
    fresh = true;
}

void Renderer::State::abandon() {
    try {
        if (renderer && renderer->hasGuide())
            passes->abandonStep();
    } catch (const Error&) { // a device that is lost keeps nothing of the pass either
    }
}

Interaction Renderer::State::interaction() const {
    return {.submissionSeconds = call ? callSeconds : 0, .beforeSubmission = call, .compiling = compiling};
}

void Renderer::State::follow() {
    if (!source)
        return;
    const std::lock_guard lock(source->mutex);
    for (std::uint32_t p = 0; p < revisions.size(); ++p) {
        if (revisions[p] == source->revisions[p])
            continue;
        revisions[p] = source->revisions[p];
        if (!digests_.empty())
            digests_[1 + p] = digestOf(source->scene.parameters[p]);
        const bool differentiable = std::find(parameters.begin(), parameters.end(), p) != parameters.end();
        const cmpg::Parameter &now = source->scene.parameters[p], &before = scene.parameters[p];
        if (renderer && differentiable && now.width == before.width && now.height == before.height) {
            renderer->setParameter(p, now.values);
        } else {
            drop(); // kernels are made for the values of the others, buffers for its size
            scene.parameters[p] = source->scene.parameters[p];
        }
    }
}

void Renderer::State::giveBack() {
    if (!source)
        return;
    const std::lock_guard lock(source->mutex);
    for (const std::uint32_t p : parameters) {
        source->scene.parameters[p] = scene.parameters[p];
        revisions[p] = ++source->revisions[p];
        if (!digests_.empty())
            digests_[1 + p] = digestOf(scene.parameters[p]);
    }
}

PassView::PassView(const cmpg::Scene& scene, const PassOptions& pass) {
    if (pass.from)
        moved_ = movedCamera(scene, *pass.from);
    view_.camera = moved_ ? &*moved_ : &scene.camera(pass.camera);
    std::tie(view_.width, view_.height) = imageSize(*view_.camera, given(pass.width), given(pass.height), 512);
}

std::uint32_t Renderer::State::indexOf(const Direction& direction) const {
    const std::uint32_t index = scene.parameter(direction.parameter);
    if (std::find(parameters.begin(), parameters.end(), index) == parameters.end())
        throw Error(ErrorKind::Usage, direction.parameter + " was not named when the renderer was made", "kernels are made for the parameters that were",
                    "name it there", {"param"});
    if (direction.values.size() != scene.parameters[index].entries())
        throw Error(ErrorKind::Usage,
                    "the direction of " + direction.parameter + " has " + std::to_string(direction.values.size()) + " values, not " +
                        std::to_string(scene.parameters[index].entries()),
                    {}, "give one for every entry of the parameter");
    return index;
}

std::vector<double> Renderer::State::spend(const PassOptions& how, const View& view, const PassKey& key, bool continues, const Estimate& estimate) {
    SampleBudget budget;
    budget.batches = batchesOf(how);
    budget.samples = samplesOf(how) / budget.batches;
    if (how.errorTarget > 0)
        budget.error = how.errorTarget;
    if (how.timeBudget > 0) {
        budget.seconds = how.timeBudget;
        budget.clock = [this] { return clock_.seconds(); };
    }
    BudgetedEstimate found = spendBudget(
        budget, [&](const BatchPart& part) { return estimate(part.samples, partKey(key, part, budget.batches, continues)); },
        [&](const BudgetedEstimate& so) {
            if (how.onImage)
                how.onImage(toImage(so.mean, view.width, view.height));
        });
    told.spp = found.samples * budget.batches;
    told.batches = budget.batches;
    told.error = found.error;
    told.end = found.end;
    return std::move(found.mean);
}

std::recursive_mutex& mutexOf(Device::State& device) {
    if (device.process() != ::getpid())
        throw Error(ErrorKind::Device, "the device was opened by another process", "this one was forked from it, as multiprocessing does",
                    "open scenes and renderers in the process that uses them, or have processes spawned");
    return device.mutex;
}

Renderer::State::Work::Work(State& state) : lock_(mutexOf(*state.device)), state_(state) {
    if (state.working)
        throw Error(ErrorKind::Usage, "this renderer is at work", "a call back of a pass or a step asks it, or its recovery, for another one",
                    "ask when that is done, or have another renderer do it");
    state.follow();
    state.working = true;
}

Renderer::State::Before Renderer::State::begin(Mode mode, const View& view, const PassOptions& how) {
    clock_ = {};
    ensure(mode, how.train > 0, how.anew);
    renderer->setInteraction(interaction());
    told = {};
    told.width = view.width;
    told.height = view.height;
    told.spp = samplesOf(how);
    return {renderer->statistics(), passes->trainSeconds()};
}

void Renderer::State::finish(Mode mode, const PassOptions& how, const Before& before, PassReport* report) {
    tell(mode, before);
    if (how.strict)
        requireFew();
    if (report)
        *report = std::move(told);
}

void Renderer::State::requireSameOnAll(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input,
                                       std::uint32_t before) {
    Communicator& ranks = device->ranks();
    if (ranks.size() > 1)
        agree(ranks, checked(ranks, [&] { return asked(mode, view, how, input, before); }), "has asked for another pass",
              "it was given another scene, other values, another adjoint or other options");
}

std::string Renderer::State::asked(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input,
                                   std::uint32_t before) {
    if (how.timeBudget > 0)
        throw Error(ErrorKind::Usage, "a time budget does not run on several ranks", "their clocks differ", "give samples, batches or an error target instead",
                    {"time-budget"});
    if (digests_.empty()) {
        std::string rest;
        for (const auto& [name, value] : contentIdentity(scene, {}, {}, {}))
            rest += value;
        digests_.push_back(rest);
        for (const cmpg::Parameter& parameter : scene.parameters)
            digests_.push_back(digestOf(parameter));
    }
    std::ostringstream all;
    for (const std::string& digest : digests_)
        all << digest;
    all.precision(17);
    for (const std::uint32_t p : parameters)
        all << ' ' << p;
    const PathOptions& paths = options.paths;
    const GuideOptions& guide = paths.guide;
    for (const double number : {double(paths.maxDepth), double(paths.sampling), double(paths.pixelSampling), double(paths.roulette), double(paths.positivize),
                                double(paths.lightSampling), double(paths.sampler), double(paths.guideMemory), double(guide.keep), double(guide.share),
                                double(guide.rouletteEffort), double(guide.cellRecords), guide.directionShare, guide.forgetting})
        all << ' ' << number;
    for (const double number : {double(mode), double(how.frame), double(view.width), double(view.height), double(how.spp),
                                double(how.train), double(how.trainSpp), double(how.anew), double(how.frozen), how.errorTarget, double(how.batches),
                                double(how.layers), double(before)})
        all << ' ' << number;
    const CameraInfo camera = describe(*view.camera);
    for (const float number : camera.toWorld)
        all << ' ' << number;
    all << ' ' << camera.name << ' ' << camera.orthographic << ' ' << camera.yfov << ' ' << camera.ymag << ' ' << how.seed;
    for (const std::vector<float>* values : input)
        all << ' ' << digestOf(*values);
    return all.str();
}

PassReport Renderer::State::totals(Mode mode) const {
    PassReport all;
    if (!renderer)
        return all;
    const RenderStatistics& statistics = renderer->statistics();
    all.learningSeconds = passes->trainSeconds();
    all.paths = statistics.paths;
    all.rays = statistics.rays;
    all.dropped = statistics.dropped;
    all.refusedSplits = statistics.refusedSplits;
    all.guided = renderer->hasGuide();
    if (const SdTree* const known = guide()) {
        all.guideCells = std::uint32_t(known->cells().size());
        all.guideUpdates = known->updates();
    }
    const SamplingDecision decision = mode == Mode::Render ? passes->imageDecision() : passes->decision();
    all.sampling = decision.method.kind;
    all.roulette = decision.method.roulette;
    all.figures = figuresOf(decision);
    all.depths = statistics.guided;
    return all;
}

void Renderer::State::tell(Mode mode, const Before& before) {
    const RenderStatistics& was = before.statistics;
    PassReport now = totals(mode);
    told.learningSeconds = now.learningSeconds - before.learned;
    told.paths = now.paths - was.paths;
    told.rays = now.rays - was.rays;
    for (const auto& [kind, count] : now.dropped) {
        const auto known = was.dropped.find(kind);
        told.dropped[kind] = count - (known == was.dropped.end() ? 0 : known->second);
    }
    told.refusedSplits = now.refusedSplits;
    told.depths = std::move(now.depths);
    for (std::size_t d = 0; d < std::min(told.depths.size(), was.guided.size()); ++d) {
        const GuidedDepth& known = was.guided[d];
        GuidedDepth& depth = told.depths[d];
        depth = {depth.drawn - known.drawn, depth.guided - known.guided, depth.dead - known.dead, depth.lightShare - known.lightShare};
    }
    told.guided = guided;
    told.guideCells = now.guideCells;
    told.guideUpdates = now.guideUpdates;
    told.sampling = guided ? now.sampling : Sampling::Bsdf;
    told.roulette = guided && now.roulette;
    told.figures = std::move(now.figures);
}

void Renderer::State::requireFew() const {
    std::uint64_t lost = 0;
    for (const auto& [kind, count] : told.dropped)
        lost += count;
    if (tooMany(lost, told.paths))
        throw overflowed();
}

} // namespace cmpg::v1
