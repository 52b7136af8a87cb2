// The renderer: images, forward gradient images and reverse gradients of one scene on one device.
#pragma once

#include "guiding/field/sd_tree.h"
#include "render/film.h"
#include "render/pass_plan.h"
#include "scene/image.h"
#include "scene/scene.h"
#include "vk/device.h"

#include <cmpg/error.h>
#include <cmpg/report.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <span>

namespace cmpg {

class Communicator;

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
    std::uint64_t guideMemory = std::uint64_t(64) << 20; // bytes of device memory, which say guide.maxNodes
    // Who shares the passes: every rank makes the same calls with the same arguments, takes some of the pixels, and gets the whole result, the same bits
    // as from one rank. Null: this process alone. It outlives the renderer.
    Communicator* ranks = nullptr;
};

// An image, and what is to be subtracted from it for the image under the second set of values.
struct ImageDifference {
    Image image, difference; // the latter empty where it was not asked for
};

// Which samples of their sequences pixels get, by pixel.
struct SampleRanges {
    std::span<const std::uint32_t> counts; // empty: as many as the pass says
    std::span<const std::uint32_t> firsts; // where they begin; empty: at PassKey::firstSample
};

// An image in two halves with random numbers of their own. How they differ is their variance; a product of both has no bias by noise.
struct ImageHalves {
    std::array<ImageDifference, 2> half;
    std::uint32_t samples = 0;           // of each half: of every pixel, or the most of any
    std::vector<std::uint32_t> counts{}; // of each half, by pixel; empty: `samples` each
    std::uint32_t count(std::size_t pixel) const { return counts.empty() ? samples : counts[pixel]; }
};

// For passes that somebody waits for, or wants to end. Results do not depend on it.
struct Interaction {
    double submissionSeconds = 0; // about how long a submission may take; 0: as long as the pools are large
    // Before every submission of a pass. What it throws ends the pass as if it had never begun: films, gradients and the numbers of later
    // passes are what they would have been. Records for the guide stay; discardRecords() forgets them.
    std::function<void()> beforeSubmission;
    std::function<void(bool begins)> compiling; // kernels
};

struct RenderStatistics {
    std::vector<GuidedDepth> guided; // by depth; empty where nothing was guided
    std::uint64_t paths = 0, rays = 0; // since construction
    std::map<std::string, std::uint64_t> dropped; // non-finite or saturated contributions, by kernel and kind
    std::uint64_t repeatedPasses = 0;             // in reverse mode, with another unit of the gradient sums; their paths and rays count again
    std::uint64_t refusedSplits = 0;              // of the guide, for want of memory, at its last update
};

// Whether so many contributions that were left out leave no estimate of anything; and the error that says so.
constexpr bool tooMany(std::uint64_t lost, std::uint64_t paths) { return double(lost) > 0.01 * double(paths); }
inline Error overflowed() {
    return {ErrorKind::Numerical, "more than one path in a hundred was dropped", "values of the scene are so large or small that floats overflow",
            "look for extreme emission, intensities or sizes in the scene"};
}

struct FirstVertices;
struct KernelSize;

class Renderer {
  public:
    // `scene` outlives the renderer and holds the current values of its parameters.
    Renderer(Device& device, Scene& scene, const RenderConfig& config);
    ~Renderer();

    enum class Mode { Render, Forward, Reverse, Difference };
    // Allocates the pools and compiles the kernels of these modes, so that no pass has to; without it the first pass of a mode does.
    void prepare(std::initializer_list<Mode> modes, bool layers = false);

    // The same for the kernels of passes of this plan, with the guide as it is or, `learned`, once it knows something.
    void prepare(Mode mode, const PassPlan& plan, bool layers = false, bool learned = false);
    // Passes of these modes will come: the pools have room for them.
    void expect(std::initializer_list<Mode> modes);
    // Begins to make the kernels of such passes, one after the other, and returns.
    void prepareAhead(std::span<const std::pair<Mode, PassPlan>> passes);
    bool isPrepared(Mode mode, const PassPlan& plan) const; // compiled

    // New values of one parameter (entries() floats, as in Parameter::values). Rebuilds light distributions where they depend on it.
    void setParameter(std::uint32_t parameter, std::span<const float> values);
    // The second set of values, for which all sampling stays at setParameter's values. Frozen evaluation: the only one that scattering and
    // emission are evaluated with. renderDifference(): both are, and only differentiable parameters may differ. Empty span: the parameter has the same
    // values in both.
    void setSecondValues(std::uint32_t parameter, std::span<const float> values);

    void setInteraction(Interaction interaction);
    // Fits the guide to the records left since the last call, on the host; the next pass publishes it, unless publishGuide() did. Older records fade
    // where setParameter() was called since, and with `forget`: in steps of an optimization, whether they move or not, so that resumed ones are alike.
    UpdateReport updateGuide(bool forget = true);
    void publishGuide();
    void discardRecords(); // left since then, if any
    bool hasGuide() const; // room for one: RenderConfig::guiding
    const SdTree& guide() const;
    void setGuide(SdTree tree); // of this scene's box

    // Passes draw as `plan` says, and tell what they cost in `result`, if it is not null.

    // RGB radiance. `spp` samples in every pixel.
    Image render(const View& view, std::uint32_t spp, const PassKey& key, const PassPlan& plan = {}, PassResult* result = nullptr,
                 Layers* layers = nullptr);

    // The image, and how it differs from that of the second set of values along the same paths: exactly 0 where a pixel's paths meet nothing
    // that differs. Needs RenderConfig::differences.
    // `counts`: samples of each pixel, one at least, or empty for `spp` everywhere.
    ImageDifference renderDifference(const View& view, std::uint32_t spp, const PassKey& key, const SampleRanges& samples = {},
                                     const PassPlan& plan = {}, PassResult* result = nullptr);

    // Derivative image along `directions[i]` (entries() floats each) of parameters `parameters[i]`, summed: sum_i dI/dp_i . v_i.
    Image forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                  std::span<const std::vector<float>> directions, const PassPlan& plan = {}, PassResult* result = nullptr, Layers* layers = nullptr);

    // The same, adding `spp` samples per pixel to a film of the view's size: those that follow the film's in the sequence of `key`. They leave
    // no records.
    void render(const View& view, std::uint32_t spp, const PassKey& key, Film& film, const PassPlan& plan = {});
    void forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                 std::span<const std::vector<float>> directions, Film& film, const PassPlan& plan = {});
    void renderDifference(const View& view, std::uint32_t spp, const PassKey& key, Film& film, const PassPlan& plan = {}); // the image alone

    // Adds adjoint^T . dI/dp for all differentiable parameters to `gradients` (one vector of entries() doubles per entry of
    // RenderConfig::differentiable). `adjoint`: 3 channels, dLoss/dpixel. `perPixel`: samples each pixel gets, or empty for `spp`
    // everywhere; `weights`: 1/E[samples] per pixel, used with perPixel. `firstVertices`, if any: where the pass's camera rays met the scene.
    PassResult reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                       std::span<const float> weights, std::vector<std::vector<double>>& gradients, const PassPlan& plan = {}, FirstVertices* firstVertices = nullptr);

    const RenderStatistics& statistics() const;
    // The features by name, and the kernels of these modes' passes by this plan, where the guide knows something. Allocates their pools, compiles
    // nothing.
    std::vector<std::pair<std::string, std::string>> describeFeatures() const;
    std::vector<KernelSize> allocate(std::span<const Mode> modes, const PassPlan& plan = {});

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
