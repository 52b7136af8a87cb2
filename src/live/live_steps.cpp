// The optimisation of a session: one step at a time, with what is shown of it.
#include "imaging/parameter_image.h"
#include "live/live_work.h"
#include "session/library_options.h"

#include <algorithm>
#include <limits>

namespace cmpg {

void LiveWork::dropOptimization(bool keepState) {
    if (run_ && run_->begun() && keepState) {
        kept_ = run_->optimization().state();
        kept_.images.clear(); // of other parameters, or of another view
        kept_.imageValues.clear();
        kept_.losses.clear();
        keptParameters_ = run_->optimization().parameters();
    }
    if (!keepState) {
        kept_ = {};
        keptParameters_.clear();
        loss_.clear();
        state_.step = 0;
        state_.loss = nullptr;
        state_.secondsPrimal = state_.secondsGradient = state_.secondsUpdate = state_.rate = 0;
    }
    if (run_)
        run_->end();
}

void LiveWork::ensureOptimization() {
    if (run_->begun())
        return;
    RecoveryRun::Steps steps{.config = optimizeConfig(options_), .views = {}};
    OptimizeConfig& config = steps.config;
    config.targets = scene_.targets;
    for (std::size_t v = 0; v < scene_.views(); ++v)
        steps.views.push_back(scene_.view(v));
    config.onImage = [this](std::size_t view, const Image& image) {
        if (view != settings_.view)
            return;
        state_.imageSamples = settings_.spp;
        showImage(image);
        hooks_.publish();
    };
    // Parameters that stay keep their moments; new ones begin here.
    steps.start.step = kept_.step;
    for (const std::uint32_t p : settings_.parameters) {
        const auto found = std::find(keptParameters_.begin(), keptParameters_.end(), p);
        if (found != keptParameters_.end()) {
            steps.start.moments.push_back(kept_.moments[std::size_t(found - keptParameters_.begin())]);
            continue;
        }
        steps.start.moments.push_back(initialMoments(config.optimizer, scene_.scene.parameters[p]));
        steps.start.moments.back().start = kept_.step;
    }
    run_->begin(std::move(steps));
}

void LiveWork::step() {
    ensureOptimization();
    Optimization& run = run_->optimization();
    run.setSamples(settings_.spp, settings_.sppGradient);
    run.setRateFactor(double(settings_.rateFactor));
    run_->passes().setLearning(guides() && run.state().step < options_.freeze.value_or(std::numeric_limits<std::uint32_t>::max()));
    const StepReport report = run.step();
    run_->passes().setLearning(false);
    steps_ -= std::min(steps_, 1u);

    loss_.push_back(report.loss);
    state_.step = run.state().step;
    state_.loss = std::make_shared<const std::vector<double>>(loss_);
    state_.rate = report.rate;
    state_.secondsPrimal = report.secondsPrimal;
    state_.secondsGradient = report.secondsGradient;
    state_.secondsUpdate = report.secondsUpdate;
    state_.samplesPerSecond = double(report.samples) / std::max(1e-6, report.secondsPrimal + report.secondsGradient);
    const Parameter& first = scene_.scene.parameters[settings_.parameters.front()];
    showParameter();
    show(LivePicture::ParameterGradient, std::make_shared<const Image>(parameterImage(first, run.gradients().front())));
    const std::uint32_t fadingSteps = fadingSteps_;
    restartFilms(); // the parameters moved
    fadingSteps_ = fadingSteps;
    state_.imageSamples = settings_.spp;
    fadeGradient();
    updateGuideFigures();
}

// One sample per pixel of the gradient image after every step, averaged over the last steps, since the image changes little between them.
void LiveWork::fadeGradient() {
    constexpr std::uint32_t kSteps = 10;
    const View v = view();
    Film film(v.width, v.height);
    run_->passes().forward(v, 1, {.seed = options_.seed, .step = state_.step, .pass = 1}, settings_.parameters, directions_, film);
    const Image now = film.image();
    fadingSteps_ = std::min(fadingSteps_ + 1, kSteps);
    if (fadingSteps_ == 1 || fading_.values.size() != now.values.size())
        fading_ = now;
    else
        for (std::size_t i = 0; i < now.values.size(); ++i)
            fading_.values[i] += (now.values[i] - fading_.values[i]) / float(fadingSteps_);
    state_.gradientFading = true;
    state_.gradientSamples = fadingSteps_;
    show(LivePicture::Gradient, std::make_shared<const Image>(fading_));
    if (settings_.layers) {
        expose(v, 1, image_.film, false);
        showLayers(image_.film);
    }
}

} // namespace cmpg
