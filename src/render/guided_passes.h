// Passes by the methods that were asked for or found best: learning, trials, halves, signs.
#pragma once

#include "guiding/guide_file.h"
#include "guiding/policy/sampling_policy.h"
#include "render/pixel_sampling.h"
#include "render/renderer.h"

#include <optional>

namespace cmpg {

struct GuidedOptions {
    Sampling sampling = Sampling::Auto;
    PixelSampling pixels = PixelSampling::Adjoint; // reverse mode
    bool positivize = false;                       // two half-budget derivative passes, one per sign
    bool roulette = true;                          // reverse mode, where it pays
    bool immediate = false;                        // optimisations: learn and try all methods from the first step, whatever the noise
};

class GuidedPasses {
  public:
    // The renderer must have been made with RenderConfig::guiding unless the options need no guide (Bsdf and no roulette).
    GuidedPasses(Renderer& renderer, const GuidedOptions& options);
    ~GuidedPasses();

    // Compiles the kernels of every method that passes of these modes may be drawn, so that none has to; where setLearning() turned learning on,
    // those of its steps.
    void prepare(std::initializer_list<Renderer::Mode> modes);
    // The same for the next pass of a mode alone, as it is decided now.
    void prepareNext(Renderer::Mode mode, bool layers = false);
    // Begins to make the kernels of the next pass of each of these modes, and returns.
    void prepareAhead(std::initializer_list<Renderer::Mode> modes);
    // Of how many of these modes the next pass, as it is decided now, has kernels that are not compiled.
    std::uint32_t unprepared(std::initializer_list<Renderer::Mode> modes) const;

    // `passes` learning passes of `spp` samples per pixel each at the current parameters, with random numbers of their own; no part of
    // any result. For auto and the roulette gate they measure variance and rays of each kind. `first`: how many there were already.
    void trainRender(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, std::uint32_t first = 0);
    void trainForward(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed,
                      std::span<const std::uint32_t> parameters, std::span<const std::vector<float>> directions, std::uint32_t first = 0);
    void trainReverse(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, const Image& adjoint);

    // As the functions of Renderer, drawn as decided. They leave no records unless learning() was turned on.
    Image render(const View& view, std::uint32_t spp, const PassKey& key, Layers* layers = nullptr);
    Image forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                  std::span<const std::vector<float>> directions, Layers* layers = nullptr); // none of positivized passes
    // `spp` samples in all, at least one in each half. `difference`: with how they differ from the images under the second set of values; only then
    // `samples` may say how many each pixel gets in each half, one at least, and which.
    ImageHalves renderHalves(const View& view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples = {});
    // The method of this step's images, and what passes so far tell of the variance of one sample by a method, summed over the pixels. 0: not known.
    Sampling imageMethod() const;
    double imageVariance(Sampling method) const;
    // An image to keep, drawn by the method found best so far: nothing is learned from it, so no later pass depends on it. `difference`: by the
    // kernels of renderHalves() with that, which choose light samples in another way than others.
    Image picture(const View& view, std::uint32_t spp, const PassKey& key, bool difference);
    void picture(const View& view, std::uint32_t spp, const PassKey& key, bool difference, Film& film); // adds them to a film
    // Further samples of a film, by the method found best so far, learning or not. They leave no records; forward ignores positivization.
    void render(const View& view, std::uint32_t spp, const PassKey& key, Film& film);
    void forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                 std::span<const std::vector<float>> directions, Film& film);
    // Pixel sampling included. Returns the number of camera paths.
    std::uint64_t reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients);

    // The same in two halves of spp / 2 samples, one at least, with numbers of their own: adds their mean, and to `half` half of how they differ.
    std::uint64_t reverseHalves(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>& half);

    // Of a gradient that is the mean of several such passes: reverse() without a word on how noisy it is, which tellNoise() says of the whole. `half`: half of
    // how two halves of it differ; `sum`: the gradient of all views so far, this one included.
    std::uint64_t reversePart(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                              std::vector<std::vector<double>>& gradients);
    void tellNoise(const std::vector<std::vector<double>>& half, const std::vector<std::vector<double>>& sum);

    // As reverse(), but nothing is learned from it, so no later pass depends on it. Of no sign alone. `firstVertices`: as in Renderer::reverse().
    std::uint64_t reverseApart(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                               std::vector<std::vector<double>>& gradients, FirstVertices* firstVertices = nullptr);

    // For optimisations: endStep() rebuilds the guide from what passes recorded and decides anew. The first steps sample by the materials alone, without
    // recording, and tell how noisy its gradients are; Exploration decides whether other methods are worth trying, SamplingChoice which. A
    // derivative pass that is to tell its noise runs in two halves with numbers of their own, and its result is the mean. Where no guide
    // pays, most steps leave no records and are not measured (SamplingChoice::rests), which saves a third of a pass.
    // The next pass brings what was learned to the device, unless publish() did: apart, so that a device that is lost then leaves a
    // whole step behind.
    void setLearning(bool on);
    bool learning() const;
    void endStep();
    void publish();
    // PassResult's, of the last derivative pass in reverse mode; 0 where it was not measured.
    double concentration() const;
    // As the last step left it, also in the midst of one.
    GuidedState state() const;
    // With the tree that belongs to it, and learning as it was. Error(Input) if it is of other methods of sampling, or the tree does not fit.
    void restore(GuidedState state, std::optional<SdTree> tree);
    // After a pass that was ended early: forgets what was recorded and measured since the last step or learning pass ended, so that
    // it can begin again.
    void abandonStep();

    SamplingDecision decision() const;      // of derivative passes
    SamplingDecision imageDecision() const; // of images
    double trainSeconds() const; // learning and rebuilding so far

    GuideContext guideContext() const; // to save with Renderer::guide()
    void load(LoadedGuide guide);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cmpg
