// Which method of sampling the passes of a run use, and in which steps the guide learns.
#include "guiding/policy/sampling_policy.h"

#include <algorithm>

namespace cmpg {
namespace {

constexpr double kRecordCost = 0.33; // of recording and measuring, in passes

std::vector<SamplingMethod> methodsOf(Sampling asked, bool derivatives, bool roulette) {
    std::vector<Sampling> kinds{asked};
    if (asked == Sampling::Auto)
        kinds = derivatives ? std::vector{Sampling::Bsdf, Sampling::Conditional, Sampling::Primal} : std::vector{Sampling::Bsdf, Sampling::Primal};
    std::vector<SamplingMethod> methods;
    for (const bool r : {false, true})
        for (const Sampling k : kinds)
            if (!r || roulette)
                methods.push_back({k, r});
    return methods;
}

} // namespace

std::vector<MethodFigures> figuresOf(const SamplingDecision& decision) {
    std::vector<MethodFigures> figures;
    for (const bool roulette : {false, true})
        for (const auto& [kind, f] : roulette ? decision.rouletteFigures : decision.figures)
            figures.push_back({kind, roulette, f.variance, f.rays, f.passes});
    return figures;
}

SamplingPolicy::SamplingPolicy(Sampling asked, bool roulette, bool immediate)
    : images(methodsOf(asked, false, false)), derivatives(methodsOf(asked, true, roulette)), immediate_(immediate),
      stepStart_{images, derivatives, exploration_, 0} {
    beginStep();
}

SamplingMethod SamplingPolicy::imageMethod() const { return learning ? plan_.image : images.best(); }

SamplingMethod SamplingPolicy::derivativeMethod() const {
    if (learning)
        return plan_.derivative;
    return trained_ ? derivatives.best() : SamplingMethod{derivatives.methods()[0].kind, false};
}

SamplingMethod SamplingPolicy::settledMethod(const SamplingChoice& choice) const {
    return {trained_ ? choice.best().kind : choice.methods()[0].kind, false};
}

bool SamplingPolicy::mayGuide() const {
    return std::any_of(derivatives.methods().begin(), derivatives.methods().end(), [](const SamplingMethod& m) { return m.kind != Sampling::Bsdf; });
}

bool SamplingPolicy::mayRoulette() const {
    return std::any_of(derivatives.methods().begin(), derivatives.methods().end(), [](const SamplingMethod& m) { return m.roulette; });
}

void SamplingPolicy::beginStep() {
    stepStart_ = {images, derivatives, exploration_, reference};
    rays_ = 0;
    noise = {};
    plan_ = {.image = images.methods().front(), .derivative = derivatives.methods().front()};
    const std::optional<SamplingChoice::Trial> imageTrial = images.trial();
    if (const std::optional<SamplingChoice::Trial> trial = derivatives.trial()) {
        planTrial(*trial);
    } else {
        plan_.derivative = derivatives.next(step_);
        plan_.halves = derivatives.tries(step_);
        plan_.record = !(derivatives.rests(step_) && (imageTrial || images.rests(step_)));
    }
    // Images are tried beside derivatives, whose kernels are made for both.
    plan_.imageTrial = plan_.record && imageTrial;
    if (!imageTrial)
        plan_.image = images.next(step_);
    else if (plan_.imageTrial)
        plan_.image = imageTrial->method;
}

void SamplingPolicy::planTrial(const SamplingChoice::Trial& trial) {
    const std::uint32_t newKinds = trial.first ? 2 : 0; // images are recorded, too
    const bool asked = immediate_ || derivatives.methods().front() != SamplingMethod{}; // for a guide
    if (asked || exploration_.allows(newKinds)) {
        plan_.derivative = trial.method;
        plan_.record = plan_.trial = true;
        plan_.halves = trial.measured;
        plan_.newKinds = newKinds;
    } else {
        plan_.halves = exploration_.watches(step_);
    }
}

void SamplingPolicy::endStep() {
    if (plan_.halves && plan_.derivative == SamplingMethod{})
        if (const std::optional<double> told = noise.ratio())
            exploration_.observeNoise(*told);
    const double kernels = kKernelRays * plan_.newKinds, rays = double(rays_);
    exploration_.spend(rays + kernels, kernels + (plan_.trial ? kRecordCost * rays : 0));
    if (plan_.trial)
        derivatives.endTrial(plan_.derivative);
    if (plan_.imageTrial)
        images.endTrial(plan_.image);
    trained_ = true;
    ++step_;
    beginStep();
}

void SamplingPolicy::abandonStep() {
    images = stepStart_.images;
    derivatives = stepStart_.derivatives;
    exploration_ = stepStart_.exploration;
    reference = stepStart_.reference;
    rays_ = 0;
    noise = {};
}

void SamplingPolicy::trust() {
    trained_ = true;
    exploration_.hurry(); // who brings a guide wants it tried
    beginStep();
}

SamplingDecision SamplingPolicy::decide(const SamplingChoice& choice) const {
    SamplingDecision d;
    d.method = trained_ ? choice.best() : SamplingMethod{choice.methods()[0].kind, false};
    for (std::size_t i = 0; i < choice.methods().size(); ++i)
        if (choice.figures(i).passes > 0)
            (choice.methods()[i].roulette ? d.rouletteFigures : d.figures)[choice.methods()[i].kind] = choice.figures(i);
    return d;
}

GuidedState SamplingPolicy::state() const {
    return {stepStart_.images.state(), stepStart_.derivatives.state(), stepStart_.exploration.state(), stepStart_.reference, trained_, step_};
}

bool SamplingPolicy::fits(const GuidedState& state) const {
    return state.images.figures.size() == images.methods().size() && state.derivatives.figures.size() == derivatives.methods().size();
}

void SamplingPolicy::restore(GuidedState state) {
    images.restore(std::move(state.images));
    derivatives.restore(std::move(state.derivatives));
    exploration_.restore(state.exploration);
    reference = state.reference;
    trained_ = state.trained;
    step_ = state.step;
    beginStep();
}

} // namespace cmpg
