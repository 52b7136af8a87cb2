// Runs passes: batch after batch through the kernels, with what they leave in the film, and what they cost.
#pragma once

#include "render/gradient_units.h"
#include "render/guide.h"
#include "render/pass_batches.h"
#include "render/pass_kernels.h"

#include <optional>

namespace cmpg {

// Sums over the samples of a pixel, so far.
struct Gathered {
    gpu::FilmPixel film{}, difference{};
    gpu::LayerSample layers{};
};

class Communicator;
class BandFilm;
struct PixelBand;

class PassRunner {
  public:
    // All outlive this; `guide`: empty where there is no room for one.
    PassRunner(Device& device, const FeatureSet& features, const SceneBuffers& buffers, std::optional<Guide>& guide, const RenderConfig& config);

    PassKernels kernels;
    Interaction interaction;
    RenderStatistics statistics;

    struct Outcome {
        PassResult result;
        Unsummed unsummed;
    };
    // Calls receive(pixel, gathered) for every pixel, in order; without `receive` there is no film. Gradient sums are those of this rank's pixels, all
    // else is of all ranks.
    Outcome run(const FeatureSet::Pass& pass, const PassInput& in, const std::function<void(std::size_t, const Gathered&)>& receive);

    // Compiled, with the pools that it needs.
    PassKernels::Kernels& prepare(const FeatureSet::Pass& pass) { return kernels.prepare(pass, interaction.compiling); }
    Pools& pools() { return kernels.pools(); }
    Communicator& ranks() const;

  private:
    const GuideBuffers* guideBuffers() const { return guide_ ? &guide_->buffers : nullptr; }
    void submit(Commands& commands, std::uint32_t paths, BatchSize& batchSize) const;
    std::uint32_t capacityFor(const gpu::Batch& batch, const std::vector<gpu::QueueCounts>& counts) const;
    // Of a pass so far, by depth: sums of the fields of QueueCounts.
    enum Count { kRays, kShadowRays, kUnfinished, kDrawn, kGuided, kDead, kLightShare, kCounts };
    using Counts = std::array<std::int64_t, kCounts>;
    // A path's moment, to be summed when those of the pixels before it are.
    struct LateMoment {
        std::uint32_t pixel;
        gpu::PathMoment moment;
    };
    struct Progress;
    void runBand(const FeatureSet::Pass& pass, const PassInput& in, const PixelBand& band, Commands& commands, BatchSize& batchSize, Progress& progress,
                 const std::function<void(std::size_t, const Gathered&)>& receive);
    // Of a batch in reverse mode, from its tape.
    void readFirstVertices(const FeatureSet::Pass& pass, const gpu::Batch& batch, std::span<const std::uint32_t> offsets, FirstVertices& first) const;
    void countRays(std::vector<Counts>& counts, Communicator& ranks, PassResult& result);
    Unsummed countDropped(Communicator& ranks);

    Device& device_;
    const FeatureSet& features_;
    const SceneBuffers& buffers_;
    std::optional<Guide>& guide_;
    const RenderConfig& config_;
    bool countersOpen_ = false; // the device's counters hold what a pass that ended early left
    // Paths of a batch whose copies fit into the pools, as the passes so far showed; at first a guess.
    std::uint32_t rouletteCapacity_ = 1u << 14;
};

} // namespace cmpg
