// What stands behind a renderer of the library's surface: passes over a copy of the scene that follows its values.
#pragma once

#include "base/stopwatch.h"
#include "library/ranks.h"
#include "library/states.h"
#include "optimize/batch_parts.h"
#include "render/guided_passes.h"

#include <cmpg/renderer.h>

namespace cmpg::v1 {

struct Renderer::State {
    using Mode = cmpg::Renderer::Mode;

    std::shared_ptr<Device::State> device;
    std::shared_ptr<Scene::State> source;
    RendererOptions options;
    std::vector<std::uint32_t> parameters;
    std::vector<std::uint64_t> revisions; // of the source's parameters, as they are in `scene`
    cmpg::Scene scene;
    std::function<void()> call;
    std::unique_ptr<cmpg::Renderer> renderer; // null: to be made
    std::unique_ptr<GuidedPasses> passes;
    bool guided = false;   // the renderer has a guide
    bool roulette = false; // and what roulette takes
    bool fresh = true;     // the guide is what it was when the renderer was made

    State(std::shared_ptr<Device::State> d, std::shared_ptr<Scene::State> s, const RendererOptions& o);
    ~State();
    State(const State&) = delete;

    void drop();
    // For passes of a mode, with a guide if they `learn` first: one that has learned nothing since it was made if they learn `anew`.
    void ensure(Mode mode, bool learn, bool anew = true);
    void follow(); // takes over what has changed in the source
    View viewOf(const PassOptions& pass) const;
    // Error(Usage) on what the renderer was not made for.
    std::uint32_t indexOf(const Direction& direction) const;

    // Learning passes, then `run`; both get the samples per pixel of a pass. `input`: what it takes beside its options.
    template <class Train, class Run>
    auto pass(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, PassReport* report, Train&& train,
              Run&& run);

    // What a pass of an estimate makes: an image or gradients in a row, of `samples` per pixel with the numbers of `key`.
    using Estimate = std::function<std::vector<double>(std::uint32_t samples, const PassKey& key)>;
    // In batches. `continues`: as of partKey().
    std::vector<double> spend(const PassOptions& how, const View& view, const PassKey& key, bool continues, const Estimate& estimate);

    PassReport told; // of the pass that runs

  private:
    void begin(Mode mode, const View& view, const PassOptions& how);
    // Of several ranks: Error(Usage) if they have not been asked for the same.
    void requireSameOnAll(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input);
    void tell(Mode mode, const RenderStatistics& before, double learnedBefore);
    void requireFew() const; // contributions left out, of told

    std::vector<std::string> digests_; // of several ranks: of geometry, materials and lights, then of each parameter of `scene`
    Stopwatch clock_; // since the pass began
};

std::uint32_t samplesOf(const PassOptions& pass);  // per pixel, at most
std::uint32_t batchesOf(const PassOptions& pass);  // 0: none
void requireValid(const PassOptions& pass);

template <class Train, class Run>
auto Renderer::State::pass(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, PassReport* report,
                           Train&& train, Run&& run) {
    const std::lock_guard lock(device->mutex);
    follow();
    requireSameOnAll(mode, view, how, input);
    const auto work = [&] {
        begin(mode, view, how);
        const RenderStatistics before = renderer->statistics();
        const double learnedBefore = passes->trainSeconds();
        if (guided && how.train > 0) {
            constexpr std::uint32_t kBatched = 8; // how many the pass will have is not known yet
            fresh = false;
            train(how.trainSpp > 0 ? how.trainSpp : batchesOf(how) > 0 ? kBatched : samplesOf(how));
        }
        if (!how.frozen)
            passes->prepareNext(mode, how.layers);
        const Stopwatch watch;
        auto result = run(samplesOf(how));
        if (told.seconds == 0)
            told.seconds = watch.seconds();
        tell(mode, before, learnedBefore);
        if (how.strict)
            requireFew();
        if (report)
            *report = std::move(told);
        return result;
    };
    try {
        return together(device->ranks(), work);
    } catch (...) {
        if (guided) // it may be half of what was asked for
            drop();
        throw;
    }
}

} // namespace cmpg::v1
