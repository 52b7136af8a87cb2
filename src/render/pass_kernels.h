// What passes run with: the kernels of each kind of pass, made when one first needs them, and the pools they share.
#pragma once

#include "render/batch_size.h"
#include "render/renderer.h"
#include "render/wavefront.h"

#include <future>
#include <map>
#include <memory>
#include <thread>

namespace cmpg {

class PassKernels {
  public:
    struct Kernels {
        Wavefront wavefront;
        BatchSize batchSize; // where the time of a submission is bounded
    };

    // All outlive this. `guide`: null where there is no room for one.
    PassKernels(Device& device, const FeatureSet& features, const SceneBuffers& scene, const GuideBuffers* guide, const RenderConfig& config);

    // The kind of a pass of this plan. `learned`: the guide has something to draw from.
    FeatureSet::Pass passOf(std::uint32_t mode, bool layers, const PassPlan& plan, bool learned) const;
    // Passes of this mode will come: the pools, made anew at the next allocate(), have room for them.
    void expect(std::uint32_t mode);
    void allocate(const FeatureSet::Pass& pass);
    // With pools that suffice, and compiled. `compiling`, if any, is told when that begins and ends.
    Kernels& prepare(const FeatureSet::Pass& pass, const std::function<void(bool begins)>& compiling);
    // Begins to make the kernels of these passes in this order, on a thread of its own, and returns; prepare() takes them up.
    void prepareAhead(const std::vector<FeatureSet::Pass>& passes);
    bool isPrepared(const FeatureSet::Pass& pass) const { return kernels_.contains(pass); }
    Pools& pools() { return *pools_; }
    const Pools& pools() const { return *pools_; }

  private:
    Device& device_;
    const FeatureSet& features_;
    const SceneBuffers& scene_;
    const GuideBuffers* guide_;
    const RenderConfig& config_;
    PoolNeeds needs_;
    std::unique_ptr<Pools> pools_; // made for needs_
    std::map<FeatureSet::Pass, Kernels> kernels_;
    std::map<FeatureSet::Pass, std::future<Wavefront>> ahead_; // being made, or made and not asked for yet
    std::vector<std::jthread> makers_;
};

} // namespace cmpg
