// A recovery put together.
#include "optimize/recovery_run.h"

namespace cmpg {

RecoveryRun::RecoveryRun(Device& device, Scene& scene, const RenderConfig& config, const GuidedOptions& guided)
    : scene_(scene), parameters_(config.differentiable), renderer_(device, scene, config), passes_(std::in_place, renderer_, guided) {}

void RecoveryRun::begin(Steps steps) {
    imageMode_ = carriesImages(steps.config) ? Renderer::Mode::Difference : Renderer::Mode::Render;
    renderer_.expect({imageMode_, Renderer::Mode::Reverse});
    passes_->setLearning(steps.learn);
    end();
    model_.emplace(renderer_, *passes_, std::move(steps.views), steps.freeze);
    if (steps.wrap)
        wrapped_ = steps.wrap(*model_);
    optimization_.emplace(model(), scene_, std::move(steps.config), parameters_, std::move(steps.start));
}

void RecoveryRun::end() {
    optimization_.reset();
    wrapped_.reset();
    model_.reset();
}

void RecoveryRun::setGuided(const GuidedOptions& guided, bool kept) {
    end();
    const bool learned = renderer_.hasGuide() && !renderer_.guide().empty();
    std::optional<LoadedGuide> guide;
    if (learned && kept) {
        guide = LoadedGuide{renderer_.guide(), passes_->guideContext()};
    } else if (learned) {
        const SdTree& tree = renderer_.guide();
        renderer_.setGuide(SdTree(tree.lower(), tree.upper(), tree.config()));
    }
    passes_.emplace(renderer_, guided);
    if (guide)
        passes_->load(std::move(*guide));
}

void RecoveryRun::prepareStep() {
    passes_->prepareAhead({imageMode_, Renderer::Mode::Reverse});
    passes_->prepareNext(imageMode_);
}

} // namespace cmpg
