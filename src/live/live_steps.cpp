// The recovery of a session: one step at a time, with what is shown of it.
#include "imaging/parameter_image.h"
#include "live/live_work.h"
#include "session/library_options.h"

#include <algorithm>

namespace cmpg {

void LiveWork::dropRecovery(bool keepProgress) {
    if (recovery_ && keepProgress)
        progress_ = recovery_->progress();
    if (!keepProgress) {
        progress_ = {};
        loss_.clear();
        state_.step = 0;
        state_.loss = nullptr;
        state_.secondsPrimal = state_.secondsGradient = state_.secondsUpdate = state_.rate = 0;
    }
    recovery_.reset();
    carriedSamples_ = 0;
}

std::uint32_t LiveWork::samplesOfStep() const {
    return carriesImages() ? carriedSamples_ + std::max(settings_.spp, options_.recovery.sppDifference) : settings_.spp;
}

void LiveWork::ensureRecovery() {
    if (recovery_)
        return;
    v1::RecoveryOptions options = recoveryOptions(options_, 0);
    options.errorTarget = 0; // a step takes about as long as the one before
    recovery_.emplace(*renderer_, scene_.targets, options, progress_);
    recovery_->onImage([this](std::size_t view, const Image& image) {
        if (view != settings_.view)
            return;
        state_.imageSamples = samplesOfStep();
        state_.imageCarried = carriesImages();
        showImage(image);
        hooks_.publish();
    });
}

void LiveWork::step() {
    ensureRecovery();
    recovery_->setSamples(settings_.spp, settings_.sppGradient);
    recovery_->setRateFactor(double(settings_.rateFactor));
    const v1::RecoveryStep report = recovery_->step();
    steps_ -= std::min(steps_, 1u);

    loss_.push_back(report.loss);
    state_.step = recovery_->steps();
    state_.loss = std::make_shared<const std::vector<double>>(loss_);
    state_.rate = report.rate;
    state_.secondsPrimal = report.imageSeconds;
    state_.secondsGradient = report.gradientSeconds;
    state_.secondsUpdate = report.updateSeconds;
    state_.samplesPerSecond = double(report.paths) / std::max(1e-6, report.imageSeconds + report.gradientSeconds);
    const v1::ParameterInfo& first = scene_.parameter(settings_.parameters.front());
    showParameter();
    show(LivePicture::ParameterGradient, std::make_shared<const Image>(parameterImage(first, recovery_->gradient(first.name))));
    const std::uint32_t fadingSteps = fadingSteps_;
    restartFilms(); // the parameters moved
    fadingSteps_ = fadingSteps;
    carriedSamples_ = state_.imageSamples = samplesOfStep();
    state_.imageCarried = carriesImages();
    fadeGradient();
    updateGuideFigures();
}

// One sample per pixel of the gradient image after every step, averaged over the last steps, since the image changes little between them.
void LiveWork::fadeGradient() {
    constexpr std::uint32_t kSteps = 10;
    const Seen s = seen();
    v1::Film film(s.width, s.height);
    expose(1, film, true, state_.step);
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
        expose(1, image_.film, false);
        showLayers(image_.film);
    }
}

} // namespace cmpg
