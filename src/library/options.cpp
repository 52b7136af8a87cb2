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
    const GuideOptions& guide = options.guide;
    require(guide.share >= 0 && guide.share <= 0.95f, "guide-share", "from 0 to 0.95"); // materials must be able to draw what the guide never does
    require(guide.rouletteEffort >= 0.01f && guide.rouletteEffort <= 100, "roulette-effort", "from 0.01 to 100");
    require(guide.cellRecords >= 1 && guide.cellRecords <= (1u << 30), "cell-records", "from 1 to 1073741824");
    require(guide.directionShare >= 1e-4 && guide.directionShare <= 1, "direction-share", "from 1e-4 to 1");
    require(guide.forgetting >= 0 && guide.forgetting <= 1, "forgetting", "from 0 to 1");
    RenderConfig config;
    config.differentiable = differentiable;
    config.maxDepth = options.maxDepth > 0 ? options.maxDepth : scene.maxDepth;
    config.lightSampling = options.lightSampling;
    config.memoryBudget = options.memory << 20;
    config.guideMemory = options.guideMemory << 20;
    config.sampler = options.sampler;
    config.allFeatures = options.allFeatures;
    config.guide.cellRecords = guide.cellRecords;
    config.guide.directionShare = guide.directionShare;
    config.guide.forgetting = guide.forgetting;
    config.guideShare = guide.share;
    config.rouletteEffort = guide.rouletteEffort;
    return config;
}

GuidedOptions guidedOptions(const PathOptions& options) {
    return {.sampling = options.sampling,
            .pixels = options.pixelSampling,
            .positivize = options.positivize,
            .roulette = options.roulette,
            .immediate = options.guide.keep};
}

} // namespace cmpg::v1
