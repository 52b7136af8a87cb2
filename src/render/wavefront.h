// One batch on the device: the pools, the kernels of one mode, and the order they run in.
#pragma once

#include "render/scene_buffers.h"
#include "shared/batch.h"
#include "shared/film.h"
#include "shared/tape.h"
#include "shared/wavefront.h"

namespace cmpg {

// Device memory of one batch, sized by the budget before the first pass.
struct Pools {
    // `modes`: a bit per gpu::kMode... that will run.
    Pools(Device& device, const FeatureSet& features, std::uint32_t modes, std::uint32_t maxDepth, std::uint64_t gradientEntries, bool layers,
          std::uint64_t budget);

    std::uint32_t capacity = 0; // paths
    std::uint32_t maxDepth = 0;
    bool layers = false;

    Buffer batch, pixelOffsets, paths, adjoint, film, layerSamples, layerFilm, gradients, direction, statistics;
    Buffer rays[2], hits, shadowRays, counts;
    struct Bounce {
        Buffer vertices, visibility, tape, tangents;
    };
    std::vector<Bounce> bounces;
};

// The kernels of one mode, specialised for the scene.
class Wavefront {
  public:
    Wavefront(Device& device, const FeatureSet& features, const FeatureSet::Pass& pass);

    // Records one batch: generate_rays -> (trace_closest -> shade_vertex -> trace_shadow) x depth -> scan_tape x depth, then gather_film
    // where a film is wanted.
    void record(Commands& commands, const SceneBuffers& scene, const Pools& pools, bool film) const;
    std::vector<const Kernel*> kernels() const;
    // What the kernels are bound to at each bounce.
    std::vector<Bindings> bindings(const SceneBuffers& scene, const Pools& pools) const;

  private:
    std::uint64_t gradientSlice() const; // gradient entries one binding reaches

    Device& device_;
    FeatureSet::Pass pass_;
    Kernel generate_, prepare_, traceCamera_, trace_, shade_, shadow_, scan_, gather_;
};

} // namespace cmpg
