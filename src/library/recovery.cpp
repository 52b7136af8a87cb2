// Recoveries of the library's surface.
#include <cmpg/recovery.h>

#include "base/error.h"
#include "base/stopwatch.h"
#include "library/kept_checkpoint.h"
#include "library/ranks.h"
#include "library/recovery_identity.h"
#include "library/recovery_state.h"
#include "optimize/loaded_target.h"
#include "render/saved_guide.h"

#include <algorithm>

namespace cmpg::v1 {
namespace {

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

} // namespace

Recovery::Recovery(const Device& device, const Scene& scene, const std::vector<Target>& targets, const RecoveryOptions& options)
    : state_(makeState<State>(device.state(), *scene.state(), targets, options)) {}

Recovery::Recovery(const Renderer& renderer, const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from)
    : state_(makeState<State>(renderer.state(), targets, options, from)) {}

bool Recovery::ended() const {
    const std::lock_guard lock(state_->mutex());
    return state_->ended();
}

RecoveryProgress Recovery::progress() const {
    const std::lock_guard lock(state_->mutex());
    const OptimizeState& now = state_->optimization().state();
    auto progress = std::make_shared<RecoveryProgress::State>();
    progress->steps = now.step;
    progress->objective = state_->objective();
    for (std::size_t i = 0; i < now.moments.size(); ++i) {
        const cmpg::Parameter& parameter = state_->scene().parameters[state_->parameters()[i]];
        progress->known.push_back({parameter.name, state_->sizes[i], methodOf(state_->optimization().config(), parameter.kind), now.moments[i]});
    }
    return {std::move(progress)};
}

RecoveryStep Recovery::step() {
    State& s = *state_;
    const Renderer::State::Work work(*s.base);
    const Stopwatch watch;
    s.requireSameOnAll("step");
    StepReport report;
    const Optimization& optimization = s.optimization();
    const double share = optimization.nextWork(), compiledBefore = s.base->device->device.compileSeconds();
    const std::uint32_t kinds = s.run->kindsToCompile();
    try {
        together(s.ranks(), [&] {
            s.learning([&] {
                s.prepare(!s.shared); // who looks on may want to end the step
                report = s.optimization().step();
            });
        });
    } catch (...) {
        s.base->abandon();
        if (s.batched)
            s.batched->abandonStep();
        throw;
    }
    s.base->giveBack();
    const std::string_view loss(reinterpret_cast<const char*>(&report.loss), sizeof report.loss);
    if (together(s.ranks(), [&] { return firstOther(s.ranks(), loss); }))
        throw Error(ErrorKind::Numerical, "ranks have computed different losses", "a processor or a driver computes differently on one of the machines",
                    "start the ranks on machines of one kind");
    RecoveryStep step = stepOf(recordOf(report), report.step);
    step.seconds = watch.seconds();
    step.concentration = report.concentration;
    step.paths = report.samples;
    step.compileSeconds = std::clamp(s.base->device->device.compileSeconds() - compiledBefore, 0.0, step.seconds); // threads compile for later steps beside this one
    if (kinds > 0)
        s.kindSeconds = std::max(s.kindSeconds, step.compileSeconds / kinds);
    step.nextSeconds = s.usualPace((step.seconds - step.compileSeconds) / share) * optimization.nextWork() + s.kindSeconds * s.run->kindsToCompile();
    step.warnings = s.watch.observe(report);
    return step;
}

void Recovery::prepare() {
    State& s = *state_;
    const Renderer::State::Work work(*s.base);
    s.requireGoing();
    together(s.ranks(), [&] { s.learning([&] { s.prepare(true); }); });
}

std::vector<RecoveryStep> Recovery::history() const {
    const std::lock_guard lock(state_->mutex());
    const OptimizeState& now = state_->run->optimization().state();
    const auto first = std::uint32_t(now.step - now.history.size());
    std::vector<RecoveryStep> steps;
    for (const StepRecord& record : now.history)
        steps.push_back(stepOf(record, first + std::uint32_t(steps.size())));
    return steps;
}

std::uint32_t Recovery::steps() const {
    const std::lock_guard lock(state_->mutex());
    return state_->run->optimization().state().step;
}

bool Recovery::done() const { return steps() >= state_->steps; }

std::vector<ParameterInfo> Recovery::parameters() const {
    const std::lock_guard lock(state_->mutex());
    std::vector<ParameterInfo> infos;
    for (const std::uint32_t p : state_->parameters())
        infos.push_back(describe(state_->scene().parameters[p]));
    return infos;
}

std::vector<float> Recovery::values(const std::string& parameter, ParameterInfo* info) const {
    const std::lock_guard lock(state_->mutex());
    const cmpg::Parameter& now = state_->scene().parameters[state_->parameters()[state_->indexOf(parameter)]];
    if (info)
        *info = describe(now);
    return now.values;
}

std::vector<double> Recovery::gradient(const std::string& parameter) const {
    const std::lock_guard lock(state_->mutex());
    const std::size_t index = state_->indexOf(parameter);
    const auto& gradients = state_->run->optimization().gradients();
    return gradients.empty() ? std::vector<double>(state_->initial[index].size()) : gradients[index];
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

Image Recovery::difference(const Image& image, std::size_t target) const {
    const std::lock_guard lock(state_->mutex());
    state_->requireTarget(target);
    const LoadedTarget loaded(state_->run->optimization().config().targets[target]);
    requireSize(*loaded, image.width, image.height);
    require(image.channels == 3, "image", "of three channels");
    Image result = image;
    for (std::size_t i = 0; i < result.values.size(); ++i) {
        const bool weighs = loaded->mask.empty() || loaded->mask[i / 3] > 0, clipped = !loaded->clipped.empty() && loaded->clipped[i];
        const float off = result.values[i] - loaded->image.values[i];
        result.values[i] = !weighs || (clipped && off > 0) ? 0 : off;
    }
    return result;
}

Image Recovery::image(std::size_t target, std::uint32_t spp, bool initial) {
    State& s = *state_;
    const Renderer::State::Work work(*s.base);
    s.requirePicture(target, spp);
    s.requireSameOnAll("picture " + std::to_string(target) + ' ' + std::to_string(spp) + ' ' + std::to_string(initial));
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
    State& s = *state_;
    const Renderer::State::Work work(*s.base);
    s.requirePicture(target, spp);
    s.requireSameOnAll("picture " + std::to_string(target));
    const View& view = s.views[target];
    const OptimizeConfig& config = s.optimization().config();
    const PassKey key = pictureKey(config.seed, target);
    s.base->expose(work, cmpg::Renderer::Mode::Render, film, view, {.spp = spp, .strict = false}, {}, report,
                   [&](std::uint32_t samples, cmpg::Film& sums) { s.base->passes->picture(view, samples, key, carriesImages(config), sums); });
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
    const Renderer::State::Work work(*state_->base);
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
    const Renderer::State::Work work(*state_->base);
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
