// A recovery put together.
#include "optimize/recovery_run.h"

#include "optimize/texel_footprint.h"

#include <algorithm>

namespace cmpg {

RecoveryRun::RecoveryRun(Renderer& renderer, GuidedPasses& passes, Scene& scene, std::vector<std::uint32_t> parameters, Steps steps)
    : passes_(passes), imageMode_(carriesImages(steps.config) ? Renderer::Mode::Difference : Renderer::Mode::Render),
      model_(renderer, passes, steps.views, steps.freeze) {
    renderer.expect({imageMode_, Renderer::Mode::Reverse});
    if (steps.wrap)
        wrapped_ = steps.wrap(model_);
    if (steps.config.prior > 0) {
        std::vector<CameraRays> pictures;
        for (const View& view : steps.views)
            pictures.emplace_back(*view.camera, view.width, view.height);
        for (const std::uint32_t parameter : parameters)
            steps.config.footprints.push_back(texelFootprint(scene, parameter, pictures));
        const bool linear = std::all_of(parameters.begin(), parameters.end(), [&](std::uint32_t parameter) {
            const SlotKind kind = scene.parameters.at(parameter).kind;
            return methodOf(steps.config, kind) == OptimizerKind::GaussNewton && !isFarFromLinear(kind);
        });
        if (linear && !steps.wrap) // which may count samples until an error is reached
            steps.config.sampleShare = sampleShare(steps.config.footprints);
    }
    optimization_.emplace(model(), scene, std::move(steps.config), std::move(parameters), std::move(steps.start));
}

void RecoveryRun::prepareStep() {
    passes_.prepareAhead({imageMode_, Renderer::Mode::Reverse});
    passes_.prepareNext(imageMode_);
}

std::uint32_t RecoveryRun::kindsToCompile() const { return passes_.unprepared({imageMode_, Renderer::Mode::Reverse}); }

} // namespace cmpg
