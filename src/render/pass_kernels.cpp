// What passes run with: the kernels of each kind of pass, made when one first needs them, and the pools they share.
#include "render/pass_kernels.h"

namespace cmpg {

using gpu::kModeDifference, gpu::kModeRender, gpu::kModeReverse;

PassKernels::PassKernels(Device& device, const FeatureSet& features, const SceneBuffers& scene, const GuideBuffers* guide, const RenderConfig& config)
    : device_(device), features_(features), scene_(scene), guide_(guide), config_(config) {
    needs_.maxDepth = config.maxDepth;
    needs_.gradientEntries = scene.gradientEntries();
    needs_.guide = needs_.record = needs_.measure = config.learning;
    needs_.roulette = config.roulette;
}

FeatureSet::Pass PassKernels::passOf(std::uint32_t mode, bool layers, const PassPlan& plan, bool learned) const {
    FeatureSet::Pass pass;
    pass.mode = mode;
    pass.sobol = config_.sampler == Sampler::Sobol;
    pass.frozen = config_.frozenEvaluation && mode != kModeDifference;
    pass.layers = layers;
    pass.maxDepth = config_.maxDepth;
    pass.threads = device_.driverThreads();
    pass.bvhDepth = scene_.bvhDepth();
    pass.oneSign = plan.sign != 0 && mode != kModeRender && mode != kModeDifference;
    if (!guide_)
        return pass;
    pass.record = plan.record;
    pass.guided = features_.everything || plan.guidedKernels || (plan.method.kind != Sampling::Bsdf && learned);
    pass.roulette = mode == kModeReverse && (features_.everything || plan.rouletteKernels || (plan.method.roulette && learned));
    pass.measure = (plan.measure || plan.record) && mode == kModeReverse;
    return pass;
}

void PassKernels::expect(std::uint32_t mode) {
    needs_.modes |= 1u << mode;
    pools_.reset();
}

void PassKernels::allocate(const FeatureSet::Pass& pass) {
    PoolNeeds all = needs_;
    all.modes |= 1u << pass.mode;
    all.layers |= pass.layers;
    all.guide |= pass.guided || pass.record || pass.roulette;
    all.record |= pass.record;
    all.measure |= pass.measure;
    all.roulette |= pass.roulette;
    if (pools_ && all == needs_)
        return;
    needs_ = all;
    pools_.reset();
    pools_ = std::make_unique<Pools>(device_, features_, needs_, config_.memoryBudget);
}

void PassKernels::prepareAhead(const std::vector<FeatureSet::Pass>& passes) {
    std::vector<std::packaged_task<Wavefront()>> tasks;
    for (const FeatureSet::Pass& pass : passes)
        if (!kernels_.contains(pass) && !ahead_.contains(pass)) {
            const Wanted wanted = tasks.empty() ? Wanted::Now : Wanted::Later; // who waits for the first one compiles it next
            tasks.emplace_back([this, pass, wanted] { return Wavefront(device_, features_, pass, wanted); });
            ahead_.emplace(pass, tasks.back().get_future());
        }
    makers_.emplace_back([all = std::move(tasks)]() mutable {
        for (auto& task : all)
            task();
    });
}

PassKernels::Kernels& PassKernels::prepare(const FeatureSet::Pass& pass, const std::function<void(bool begins)>& compiling) {
    allocate(pass);
    const auto found = kernels_.find(pass);
    if (found != kernels_.end())
        return found->second;
    if (compiling)
        compiling(true);
    auto begun = ahead_.extract(pass);
    Kernels made{begun ? begun.mapped().get() : Wavefront(device_, features_, pass), {}};
    warmUp(device_, made.wavefront.kernels(), made.wavefront.bindings(scene_, *pools_, guide_).front());
    if (compiling)
        compiling(false);
    return kernels_.emplace(pass, std::move(made)).first->second;
}

} // namespace cmpg
