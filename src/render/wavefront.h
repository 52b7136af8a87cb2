// One batch on the device: the pools, the kernels of one mode, and the order they run in.
#pragma once

#include "guiding/field/guide_buffers.h"
#include "render/scene_buffers.h"
#include "shared/batch.h"
#include "shared/film.h"
#include "shared/tape.h"
#include "shared/wavefront.h"

namespace cmpg {

// What passes will need of the pools.
struct PoolNeeds {
    std::uint32_t modes = 0; // a bit per gpu::kMode... that will run
    std::uint32_t maxDepth = 8;
    std::uint64_t gradientEntries = 0;
    bool layers = false;
    bool guide = false;    // passes look up the guide
    bool record = false;   // passes leave records for it
    bool measure = false;  // the second moments of reverse passes are measured
    bool roulette = false; // paths may split

    bool has(std::uint32_t mode) const { return (modes >> mode & 1u) != 0; }
    bool tangents() const { return has(gpu::kModeForward) || has(gpu::kModeDifference); }
    bool prefixes() const { return has(gpu::kModeReverse) || (guide && has(gpu::kModeForward)); }
    bool derivatives() const { return has(gpu::kModeReverse) || has(gpu::kModeForward); }
    bool derivativeRecords() const { return record && (has(gpu::kModeReverse) || has(gpu::kModeForward)); }
    auto operator<=>(const PoolNeeds&) const = default;
};

// Device memory of one batch, sized by the budget before the first pass.
struct Pools {
    Pools(Device& device, const FeatureSet& features, const PoolNeeds& needs, std::uint64_t budget);

    std::uint32_t capacity = 0; // paths, or vertices of one bounce
    PoolNeeds needs;

    Buffer batch, pixelOffsets, paths, adjoint, film, differenceFilm, layerSamples, layerFilm, gradients, direction, statistics;
    Buffer rays[2], prefixes[2], hits, shadowRays, counts, copies, pathMoments;
    struct Bounce {
        Buffer sorted, vertices, suffixes, visibility, tape, tangents, arrivals, visits, derivatives, moments;
    };
    std::vector<Bounce> bounces;
};

// The kernels of a pass.
enum class Step { Generate, Trace, Split, Sort, ShadeEscaped, ShadePlain, ShadeDiffuse, ShadeOther, ShadeUnlit, TraceShadow, Scan, ScanUndifferentiated, GatherMoments, GatherFilm };
struct KernelChoice {
    Step step;
    const char* name;
    std::vector<std::uint32_t> constants;
};
// Those that the pass needs, specialised for the scene, in the order they first run.
std::vector<KernelChoice> chooseKernels(const FeatureSet& features, const FeatureSet::Pass& pass);

// The kernels of one kind of pass.
class Wavefront {
  public:
    Wavefront(Device& device, const FeatureSet& features, const FeatureSet::Pass& pass, Wanted wanted = Wanted::Now);

    // Records one batch: generate_rays -> (trace_closest -> split_paths -> sort_vertices -> shade_... -> trace_shadow) x depth -> scan_tape x depth, then
    // gather_film or gather_moments where they are wanted. `guide`: null where nothing is guided or recorded.
    void recordCommands(Commands& commands, const SceneBuffers& scene, const Pools& pools, const GuideBuffers* guide, bool film, bool keepRecords) const;
    std::vector<const Kernel*> kernels() const;
    // What the kernels are bound to at each bounce.
    std::vector<Bindings> bindings(const SceneBuffers& scene, const Pools& pools, const GuideBuffers* guide) const;

  private:
    // One bounce of the backward scan, once for each part of the gradients that a binding reaches.
    void recordScan(Commands& commands, Bindings bindings, const Pools& pools, std::uint32_t bounce, bool keepRecords) const;
    std::uint64_t gradientSlice() const; // gradient entries one binding reaches
    const Kernel& kernel(Step step) const { return kernels_.at(step); }
    bool has(Step step) const { return kernels_.contains(step); }

    Device& device_;
    FeatureSet features_;
    FeatureSet::Pass pass_;
    std::map<Step, Kernel> kernels_;
};

} // namespace cmpg
