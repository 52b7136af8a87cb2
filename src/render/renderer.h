// The renderer: images, forward gradient images and reverse gradients of one scene on one device.
#pragma once

#include "guiding/sampling.h"
#include "guiding/sd_tree.h"
#include "render/film.h"
#include "scene/image.h"
#include "scene/scene.h"
#include "vk/device.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <memory>

namespace cmpg {

enum class Sampler { Independent, Sobol };

// Fixed for the life of a renderer: decides which kernels are built and which buffers exist.
struct RenderConfig {
    std::vector<std::uint32_t> differentiable = {}; // parameters gradients may be asked for
    std::uint32_t maxDepth = 8;                // segments; 1 = directly seen emission only
    Sampler sampler = Sampler::Sobol;
    bool lightSampling = true; // next-event estimation with MIS
    bool allFeatures = false;  // all kernels' features and their buffers, needed or not: for comparison, the results are the same
    bool frozenEvaluation = false; // f is evaluated with a second set of values, see setSecondValues
    bool differences = false;      // a second set of values for Mode::Difference
    std::uint64_t memoryBudget = std::uint64_t(1) << 30; // bytes of transient device memory
    bool guiding = false;                                // room for a guide
    // What passes to come will ask of the pools, so that they are made once, before the first: else the first pass that does has them remade.
    bool learning = false; // records of every pass, and their variances
    bool roulette = false; // copies of split paths
    SdTreeConfig guide = {};
    float guideShare = kGuideShare, rouletteEffort = kRouletteEffort;
    std::uint64_t guideMemory = std::uint64_t(64) << 20; // bytes of device memory; bounds guide.maxNodes
};

// How the passes that follow draw directions, and what they leave behind. All but the defaults and `sign` need RenderConfig::guiding.
struct PassSampling {
    Sampling kind = Sampling::Bsdf; // not Auto
    bool record = false;            // leave records for updateGuide(); measure too
    bool keepRecords = true;        // false: none are left. The kernels are those of `record`, which saves compiling others
    // The kernels are those of guided passes, and in reverse mode of roulette, though this pass may have neither: one set for passes by several
    // ways, with the results of their own kernels. `roulette` needs RenderConfig::roulette.
    bool guidedKernels = false, rouletteKernels = false;
    bool measure = false;           // reverse mode: estimate PassMeasure::variance
    bool roulette = false;          // reverse mode: roulette and splitting by derivative-to-go
    int sign = 0;                   // positivization: only derivative terms of this sign
    double reference = 0;           // roulette: PassMeasure::reference of an earlier pass with this adjoint
};

// What a pass cost and how it scattered.
struct PassMeasure {
    std::uint64_t paths = 0, rays = 0;
    double variance = 0;  // of the result, summed over its entries: an estimate from the pass itself
    double reference = 0; // reverse mode: mean over the pixels of |adjoint| times the L1 norm of the first vertex's derivative
    double concentration = 0; // reverse mode, where it is measured: share of the few largest paths in the sum of all squares

    void add(const PassMeasure& other) {
        paths += other.paths;
        rays += other.rays;
        variance += other.variance;
        reference += other.reference;
        concentration = std::max(concentration, other.concentration);
    }
};

// Keys of the random numbers of one pass. Different passes of one step are independent.
struct PassKey {
    std::uint64_t seed = 0;
    std::uint32_t step = 0;
    // 0 primal, 1 derivative, 2 pilot, 3 learning, 4 gate of the roulette, 5 and 6 second halves of images and derivatives, 7 pictures of a report;
    // + 8: the half for negative terms; + 16 n: of the n-th batch of a command that goes in batches.
    std::uint32_t pass = 0;
    std::uint32_t firstSample = 0; // of every pixel, in its sequence; films count for themselves
};

// An image, and what is to be subtracted from it for the image under the second set of values.
struct ImageDifference {
    Image image, difference; // the latter empty where it was not asked for
};

// An image in two halves with random numbers of their own. How they differ is their variance; a product of both has no bias by noise.
struct ImageHalves {
    std::array<ImageDifference, 2> half;
    std::uint32_t samples = 0;           // of each half: of every pixel, or the most of any
    std::vector<std::uint32_t> counts{}; // of each half, by pixel; empty: `samples` each
    std::uint32_t count(std::size_t pixel) const { return counts.empty() ? samples : counts[pixel]; }
};

struct View {
    const Camera* camera = nullptr;
    int width = 512, height = 512;
};

// For passes that somebody waits for, or wants to end. Results do not depend on it.
struct Interaction {
    double submissionSeconds = 0; // about how long a submission may take; 0: as long as the pools are large
    // Before every submission of a pass. What it throws ends the pass as if it had never begun: films, gradients and the numbers of later
    // passes are what they would have been. Records for the guide stay; discardRecords() forgets them.
    std::function<void()> beforeSubmission;
    std::function<void(bool begins)> compiling; // kernels
};

// What the guide did at one depth, summed over passes.
struct GuidedDepth {
    std::uint64_t drawn = 0, guided = 0, dead = 0; // directions drawn where it knew something; from it; of these, those that led nowhere
    double lightShare = 0;                         // sum over the drawn of the share of P in the mixture; D has the rest
};

struct RenderStatistics {
    std::vector<GuidedDepth> guided; // by depth; empty where nothing was guided
    std::uint64_t paths = 0, rays = 0; // since construction
    std::map<std::string, std::uint64_t> dropped; // non-finite or saturated contributions, by kernel and kind
    std::uint64_t repeatedPasses = 0;             // in reverse mode, with another unit of the gradient sums; their paths and rays count again
    std::uint64_t refusedSplits = 0;              // of the guide, for want of memory, at its last update
};

struct KernelSize;

class Renderer {
  public:
    // `scene` outlives the renderer and holds the current values of its parameters.
    Renderer(Device& device, Scene& scene, const RenderConfig& config);
    ~Renderer();

    enum class Mode { Render, Forward, Reverse, Difference };
    // Allocates the pools and compiles the kernels of these modes, so that no pass has to; without it the first pass of a mode does.
    void prepare(std::initializer_list<Mode> modes, bool layers = false);

    // The same for the kernels of passes drawn like this, with the guide as it is or, `learned`, once it knows something.
    void prepare(Mode mode, const PassSampling& sampling, bool layers = false, bool learned = false);
    // Passes of these modes will come: the pools have room for them.
    void expect(std::initializer_list<Mode> modes);
    // Begins to make the kernels of such passes, one after the other, and returns.
    void prepareAhead(std::span<const std::pair<Mode, PassSampling>> passes);
    bool isPrepared(Mode mode, const PassSampling& sampling) const; // compiled

    // New values of one parameter (entries() floats, as in Parameter::values). Rebuilds light distributions where they depend on it.
    void setParameter(std::uint32_t parameter, std::span<const float> values);
    // The second set of values, for which all sampling stays at setParameter's values. Frozen evaluation: the only one that scattering and
    // emission are evaluated with. renderDifference(): both are. Empty span: the parameter has the same values in both.
    void setSecondValues(std::uint32_t parameter, std::span<const float> values);

    void setInteraction(Interaction interaction);
    void setSampling(const PassSampling& sampling);
    const PassMeasure& lastPass() const;
    // Fits the guide to the records left since the last call, on the host; the next pass publishes it, unless publishGuide() did.
    UpdateReport updateGuide();
    void publishGuide();
    void discardRecords(); // left since then
    bool hasGuide() const; // room for one: RenderConfig::guiding
    const SdTree& guide() const;
    void setGuide(SdTree tree); // of this scene's box

    // RGB radiance. `spp` samples in every pixel.
    Image render(const View& view, std::uint32_t spp, const PassKey& key, Layers* layers = nullptr);

    // The image, and how it differs from that of the second set of values along the same paths: exactly 0 where a pixel's paths meet nothing
    // that differs. Needs RenderConfig::differences.
    // `counts`: samples of each pixel, one at least, or empty for `spp` everywhere.
    ImageDifference renderDifference(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> counts = {});

    // Derivative image along `directions[i]` (entries() floats each) of parameters `parameters[i]`, summed: sum_i dI/dp_i . v_i.
    Image forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                  std::span<const std::vector<float>> directions, Layers* layers = nullptr);

    // The same, adding `spp` samples per pixel to a film of the view's size: those that follow the film's in the sequence of `key`.
    void render(const View& view, std::uint32_t spp, const PassKey& key, Film& film);
    void forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                 std::span<const std::vector<float>> directions, Film& film);

    // Adds adjoint^T . dI/dp for all differentiable parameters to `gradients` (one vector of entries() doubles per entry of
    // RenderConfig::differentiable). `adjoint`: 3 channels, dLoss/dpixel. `perPixel`: samples each pixel gets, or empty for `spp`
    // everywhere; `weights`: 1/E[samples] per pixel, used with perPixel.
    void reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                 std::span<const float> weights, std::vector<std::vector<double>>& gradients);

    const RenderStatistics& statistics() const;
    // For `inspect`: the features by name, and the kernels of these modes' passes as setSampling() says, where the guide knows
    // something. Allocates their pools, compiles nothing.
    std::vector<std::pair<std::string, std::string>> describeFeatures() const;
    std::vector<KernelSize> allocate(std::initializer_list<Mode> modes);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

struct KernelSize {
    Renderer::Mode mode;
    std::string kernel;
    std::uint64_t moduleBytes, specialisedBytes; // SPIR-V; after specialization and the removal of what that leaves unused
};

} // namespace cmpg
