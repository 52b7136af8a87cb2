// The recovery of a session: one step at a time, with what is shown of it.
#include "imaging/parameter_image.h"
#include "live/live_work.h"
#include "session/library_options.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

double squaredDistance(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i)
        if (const double d = double(a.values[i]) - double(b.values[i]); std::isfinite(d))
            sum += d * d;
    return sum;
}

} // namespace

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
        state_.imageSamples = settings_.spp;
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
    state_.imageSamples = settings_.spp;
    state_.imageCarried = carriesImages();
    fadeGradient();
    updateGuideFigures();
}

// The image that steps carry on has as many samples as the parameters moved little, which they do not tell. So its noise is measured: it differs from the
// refined one by the noise of both, and the refined one from what it was with fewer samples by some of its own.
bool LiveWork::outdoesCarried(const v1::Film& film) {
    const auto& carried = state_.picture(LivePicture::Image);
    Image now = film.image();
    if (!carried || carried->values.size() != now.values.size())
        return true;
    bool better = false;
    if (const double before = earlierSamples_, samples = film.samples(); before > 0 && samples > before) {
        constexpr double kClearly = 2; // times less noise
        const double noise = squaredDistance(now, earlier_) * before / (samples - before);
        better = squaredDistance(now, *carried) >= (kClearly + 1) * noise;
    }
    if (film.samples() >= 2 * earlierSamples_) {
        earlier_ = std::move(now);
        earlierSamples_ = film.samples();
    }
    return better;
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
