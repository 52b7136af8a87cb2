// Runs the tracing kernels over given rays.
#pragma once

#include "scene/bvh.h"
#include "scene/features.h"
#include "shared/bindings.h"
#include "shared/wavefront.h"
#include "vk/device.h"

#include <array>

namespace cmpg::test {

class Tracer {
  public:
    // `scene`: the tables of a scene whose features ask for them (alpha masks); they outlive the tracer.
    // `depth`: what the kernels are told of the hierarchy's; a larger one is true as well.
    Tracer(Device& device, const Bvh& bvh, std::uint32_t depth, const FeatureSet& features = {}, const Bindings& scene = {})
        : device_(device), scene_(scene), closest_(device, "trace_closest", features.traceConstants(device.driverThreads(), depth)),
          shadow_(device, "trace_shadow", features.traceConstants(device.driverThreads(), depth)), records_(device, "bvh", bvh.records.size() * sizeof(BvhRecord), MemoryKind::Scene, Texel::Rgba32ui),
          counts_(device, "counts", sizeof(gpu::QueueCounts), MemoryKind::Transient) {
        records_.uploadAll(bvh.records);
        warmUp(device, std::array{&closest_, &shadow_});
    }

    std::vector<gpu::Hit> closest(const std::vector<gpu::Ray>& rays) {
        return trace<gpu::Hit>(closest_, rays, gpu::kBindRays, gpu::kBindHits);
    }
    std::vector<std::uint32_t> visible(const std::vector<gpu::ShadowRay>& rays) {
        return trace<std::uint32_t>(shadow_, rays, gpu::kBindShadowRays, gpu::kBindVisibility);
    }
    double seconds() const { return seconds_; }           // device time of the last call, where the device times kernels
    std::uint32_t unfinished() const { return unfinished_; } // rays the last call gave up

  private:
    template <class Result, class Input>
    std::vector<Result> trace(const Kernel& kernel, const std::vector<Input>& rays, std::uint32_t inputSlot, std::uint32_t resultSlot) {
        const std::uint32_t n = std::uint32_t(rays.size());
        Buffer input(device_, "rays", n * sizeof(Input), MemoryKind::Transient, Texel::Rgba32ui);
        Buffer result(device_, "results", n * sizeof(Result), MemoryKind::Transient);
        input.uploadAll(rays);
        gpu::QueueCounts counts{};
        counts.rays = counts.shadowRays = n;
        counts_.uploadAll(std::vector{counts});
        Bindings bindings = scene_;
        bindings.set(gpu::kBindNodes, records_).set(gpu::kBindCounts, counts_).set(gpu::kBindCountsHere, counts_).set(inputSlot, input).set(resultSlot, result);
        Commands commands(device_);
        const std::uint64_t groups = (n + gpu::kTraceChunk - 1) / gpu::kTraceChunk;
        commands.dispatch(kernel, bindings, groups * kernel.localSize(), gpu::BouncePush{0, n, 1});
        const double before = device_.kernelTimes().contains(kernel.name()) ? device_.kernelTimes().at(kernel.name()).seconds : 0;
        commands.submitAndWait();
        seconds_ = device_.kernelTimes().at(kernel.name()).seconds - before;
        unfinished_ = counts_.downloadAll<gpu::QueueCounts>(1)[0].unfinished;
        return result.downloadAll<Result>(n);
    }

    Device& device_;
    Bindings scene_;
    Kernel closest_, shadow_;
    Buffer records_, counts_;
    double seconds_ = 0;
    std::uint32_t unfinished_ = 0;
};

} // namespace cmpg::test
