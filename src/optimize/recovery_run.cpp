// A recovery put together.
#include "optimize/recovery_run.h"

namespace cmpg {

RecoveryRun::RecoveryRun(Device& device, Scene& scene, const RenderConfig& config, const GuidedOptions& guided)
    : scene_(scene), parameters_(config.differentiable), renderer_(device, scene, config), passes_(renderer_, guided) {}

void RecoveryRun::begin(Steps steps) {
    imageMode_ = carriesImages(steps.config, steps.views.size()) ? Renderer::Mode::Difference : Renderer::Mode::Render;
    renderer_.expect({imageMode_, Renderer::Mode::Reverse});
    passes_.setLearning(steps.learn);
    optimization_.reset();
    wrapped_.reset();
    model_.emplace(renderer_, passes_, std::move(steps.views), steps.freeze);
    if (steps.wrap)
        wrapped_ = steps.wrap(*model_);
    optimization_.emplace(model(), scene_, std::move(steps.config), parameters_);
}

void RecoveryRun::prepareStep() {
    passes_.prepareAhead({imageMode_, Renderer::Mode::Reverse});
    passes_.prepareNext(imageMode_);
}

} // namespace cmpg
