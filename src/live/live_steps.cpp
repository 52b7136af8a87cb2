// The optimisation of a session: one step at a time, with what is shown of it.
#include "live/live_work.h"
#include "optimize/run_folder.h"
#include "session/optimize_options.h"

#include <algorithm>
#include <limits>

namespace cmpg {

void LiveWork::dropOptimization(bool keepState) {
    if (optimization_ && keepState) {
        kept_ = optimization_->state();
        kept_.images.clear(); // of other parameters, or of another view
        kept_.imageValues.clear();
        keptParameters_ = optimization_->parameters();
    }
    if (!keepState) {
        kept_ = {};
        keptParameters_.clear();
        loss_.clear();
        state_.step = 0;
        state_.loss = nullptr;
        state_.secondsPrimal = state_.secondsGradient = state_.secondsUpdate = state_.rate = 0;
    }
    optimization_.reset();
    model_.reset();
}

void LiveWork::ensureOptimization() {
    if (optimization_)
        return;
    OptimizeConfig config = optimizeConfig(options_);
    config.targets = scene_.targets;
    std::vector<View> views;
    for (std::size_t v = 0; v < scene_.views(); ++v)
        views.push_back(scene_.view(v));
    model_ = std::make_unique<RendererModel>(*renderer_, *passes_, views);
    config.onImage = [this](std::size_t view, const Image& image) {
        if (view != settings_.view)
            return;
        state_.imageSamples = settings_.spp;
        showImage(image);
        hooks_.publish();
    };
    // Parameters that stay keep their moments; new ones begin here.
    OptimizeState state{.step = kept_.step, .moments = {}};
    for (const std::uint32_t p : settings_.parameters) {
        const auto found = std::find(keptParameters_.begin(), keptParameters_.end(), p);
        if (found != keptParameters_.end()) {
            state.moments.push_back(kept_.moments[std::size_t(found - keptParameters_.begin())]);
            continue;
        }
        state.moments.push_back(initialMoments(config.optimizer, scene_.scene.parameters[p]));
        state.moments.back().start = kept_.step;
    }
    optimization_ = std::make_unique<Optimization>(*model_, scene_.scene, std::move(config), settings_.parameters, std::move(state));
}

void LiveWork::step() {
    ensureOptimization();
    optimization_->setSamples(settings_.spp, settings_.sppGradient);
    optimization_->setRateFactor(double(settings_.rateFactor));
    passes_->setLearning(guides() && optimization_->state().step < options_.freeze.value_or(std::numeric_limits<std::uint32_t>::max()));
    const StepReport report = optimization_->step();
    passes_->setLearning(false);
    steps_ -= std::min(steps_, 1u);

    loss_.push_back(report.loss);
    state_.step = optimization_->state().step;
    state_.loss = std::make_shared<const std::vector<double>>(loss_);
    state_.rate = report.rate;
    state_.secondsPrimal = report.secondsPrimal;
    state_.secondsGradient = report.secondsGradient;
    state_.secondsUpdate = report.secondsUpdate;
    state_.samplesPerSecond = double(report.samples) / std::max(1e-6, report.secondsPrimal + report.secondsGradient);
    const Parameter& first = scene_.scene.parameters[settings_.parameters.front()];
    showParameter();
    show(LivePicture::ParameterGradient, std::make_shared<const Image>(parameterImage(first, optimization_->gradients().front())));
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
    passes_->forward(v, 1, {.seed = options_.seed, .step = state_.step, .pass = 1}, settings_.parameters, directions_, film);
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
