// The options as the renderer has them.
#include "session/render_options.h"

#include "library/states.h"
#include "session/library_options.h"

namespace cmpg {

RenderConfig renderConfig(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& differentiable) {
    RenderConfig config = v1::renderConfig(pathOptions(options, options.effectiveDepth(scene.maxDepth)), scene, differentiable);
    config.guiding = usesGuide(options);
    config.learning = usesGuide(options) && options.command == Command::Optimize;
    config.roulette = usesGuide(options) && options.roulette && options.isReverse();
    config.differences = options.command == Command::Optimize && options.recovery.sppDifference > 0;
    return config;
}

} // namespace cmpg
