// Options of the library's surface as the configuration of a renderer.
#include "base/error.h"
#include "library/states.h"

namespace cmpg::v1 {

void require(bool valid, const std::string& option, const std::string& range) {
    if (!valid)
        throw Error(ErrorKind::Usage, option + " must be " + range, {}, "give it such a value", {option});
}

RenderConfig renderConfig(const PathOptions& options, const cmpg::Scene& scene, const std::vector<std::uint32_t>& differentiable) {
    require(options.maxDepth <= 1024, "max-depth", "from 1 to 1024, or 0 for the scene's own");
    require(options.memory >= 16 && options.memory <= (1u << 22), "memory", "from 16 to 4194304 MiB");
    require(options.guideMemory >= 1 && options.guideMemory <= 4096, "guide-memory", "from 1 to 4096 MiB");
    RenderConfig config;
    config.differentiable = differentiable;
    config.maxDepth = options.maxDepth > 0 ? options.maxDepth : scene.maxDepth;
    config.lightSampling = options.lightSampling;
    config.memoryBudget = options.memory << 20;
    config.guideMemory = options.guideMemory << 20;
    return config;
}

Interaction interactionOf(const std::function<void()>& call) {
    if (!call)
        return {};
    return {.submissionSeconds = kSubmissionSeconds, .beforeSubmission = call, .compiling = {}};
}

} // namespace cmpg::v1
