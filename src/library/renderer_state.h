// What stands behind a renderer of the library's surface: passes over a copy of the scene that follows its values.
#pragma once

#include "base/stopwatch.h"
#include "library/film_state.h"
#include "library/ranks.h"
#include "library/states.h"
#include "optimize/batch_parts.h"
#include "render/guided_passes.h"

#include <cmpg/renderer.h>

#include <mutex>
#include <optional>
#include <span>

namespace cmpg::v1 {

struct Renderer::State {
    using Mode = cmpg::Renderer::Mode;

    // What a renderer that is made once for all kinds of passes is made for.
    struct Capacity {
        bool guiding = false, learning = false, roulette = false, differences = false;
    };

    struct Along; // directions of a derivative

    // A piece of work with the renderer: holds the device, and has taken over what changed in the source. Error(Usage) where a call back of such work, which
    // comes from its thread, asks for another piece: it would change buffers and values that the first one uses.
    class Work {
      public:
        explicit Work(State& state);
        ~Work() { state_.working = false; }
        Work(const Work&) = delete;

      private:
        const std::lock_guard<std::recursive_mutex> lock_;
        State& state_;
    };

    std::shared_ptr<Device::State> device;
    std::shared_ptr<Scene::State> source; // null: nobody else's values are followed
    std::optional<Capacity> capacity;
    RendererOptions options;
    std::vector<std::uint32_t> parameters;
    std::vector<std::uint64_t> revisions; // of the source's parameters, as they are in `scene`
    cmpg::Scene scene;
    std::function<void()> call;
    double callSeconds = 0.2; // between two calls: soon enough for Ctrl-C
    std::function<void(bool)> compiling;
    std::unique_ptr<cmpg::Renderer> renderer; // null: to be made
    std::unique_ptr<GuidedPasses> passes;
    bool guided = false;   // the renderer has a guide
    bool roulette = false; // and what roulette takes
    bool fresh = true;     // the guide is what it was when the renderer was made
    std::uint32_t trained = 0;    // learning passes that train() made for it
    std::uint64_t generation = 0; // rises when what a recovery stands on goes
    bool working = false;         // see Work

    State(std::shared_ptr<Device::State> d, std::shared_ptr<Scene::State> s, const RendererOptions& o);
    // Of a recovery, over a copy of the scene of its own.
    State(std::shared_ptr<Device::State> d, Scene::State& s, const RendererOptions& o, const Capacity& c);
    ~State();
    State(const State&) = delete;

    pid_t process() const { return device->process(); }
    void drop();
    // For passes of a mode, with a guide if they `learn` first: one that has learned nothing since it was made if they learn `anew`.
    void ensure(Mode mode, bool learn, bool anew = true);
    void drawAnew(bool kept); // by the options as they are; with the guide as it is, or with one that has learned nothing
    // Another renderer of the scene as it is now, for Mode::Difference. It follows no values.
    std::unique_ptr<cmpg::Renderer> makeDiffering();
    Footprint footprint(std::span<const PassKind> kinds, bool learn) const;
    void abandon();           // what a pass recorded and measured before it was ended
    void follow();            // takes over what has changed in the source
    void giveBack();          // the parameters' values to the source
    Interaction interaction() const;
    PassReport totals(Mode mode) const; // of all passes
    const SdTree* guide() const { return renderer && renderer->hasGuide() && !renderer->guide().empty() ? &renderer->guide() : nullptr; } // null: knows nothing
    // Error(Usage) on what the renderer was not made for.
    std::uint32_t indexOf(const Direction& direction) const;
    Along along(std::span<const Direction> directions) const;

    // One that nothing is learned from: adds to a film.
    template <class Run>
    void expose(const Work&, Mode mode, Film& film, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, PassReport* report, Run&& run);
    // Learning passes alone; `learn` makes the one with this number, of so many samples per pixel.
    template <class Learn>
    void train(const Work&, Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, Learn&& learn);

    // Learning passes, then `run`; both get the samples per pixel of a pass. `input`: what it takes beside its options.
    template <class Train, class Run>
    auto pass(const Work&, Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, PassReport* report,
              Train&& train, Run&& run);

    // What a pass of an estimate makes: an image or gradients in a row, of `samples` per pixel with the numbers of `key`.
    using Estimate = std::function<std::vector<double>(std::uint32_t samples, const PassKey& key)>;
    // In batches. `continues`: as of partKey().
    std::vector<double> spend(const PassOptions& how, const View& view, const PassKey& key, bool continues, const Estimate& estimate);

    PassReport told; // of the pass that runs

  private:
    Capacity needsOf(Mode mode, bool learn) const; // passes of a mode, with a guide if they learn first
    RenderConfig configOf(const Capacity& needs) const;
    void make(const Capacity& needs, bool roulettePays, const std::vector<std::uint32_t>* ofGuide);
    GuidedOptions drawing(bool roulettePays) const;
    // What all passes had cost when this one began.
    struct Before {
        RenderStatistics statistics;
        double learned = 0; // seconds
    };
    Before begin(Mode mode, const View& view, const PassOptions& how);
    // Fills in what the pass did; Error(Numerical) where it left out too much.
    void finish(Mode mode, const PassOptions& how, const Before& before, PassReport* report);
    // Of several ranks, before all else that they do together: Error(Usage) if they have not been asked for the same. `before`: samples that a film has.
    void requireSameOnAll(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, std::uint32_t before = 0);
    std::string asked(Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input, std::uint32_t before);
    void tell(Mode mode, const Before& before);
    void requireFew() const; // contributions left out, of told

    std::vector<std::string> digests_; // of several ranks: of geometry, materials and lights, then of each parameter of `scene`
    Stopwatch clock_; // since the pass began
};

// Of whoever records, submits or frees. Error(Device) in another process than the one that opened the device.
std::recursive_mutex& mutexOf(Device::State& device);

// What a pass sees, with the camera where that was moved.
class PassView {
  public:
    PassView(const cmpg::Scene& scene, const PassOptions& pass);
    PassView(const PassView&) = delete;
    const View& view() const { return view_; }

  private:
    std::optional<cmpg::Camera> moved_;
    View view_;
};

cmpg::Renderer::Mode modeOf(PassKind kind);
std::uint32_t samplesOf(const PassOptions& pass);  // per pixel, at most
std::uint32_t batchesOf(const PassOptions& pass);  // 0: none
void requireValid(const PassOptions& pass);

template <class Train, class Run>
auto Renderer::State::pass(const Work&, Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input,
                           PassReport* report, Train&& train, Run&& run) {
    requireSameOnAll(mode, view, how, input);
    const auto work = [&] {
        const Before before = begin(mode, view, how);
        if (guided && how.train > 0) {
            fresh = false;
            train(how.trainSpp > 0 ? how.trainSpp : learningSamples(samplesOf(how), how.train, batchesOf(how)));
        }
        if (!how.frozen)
            passes->prepareNext(mode, how.layers);
        const Stopwatch watch;
        auto result = run(samplesOf(how));
        if (told.seconds == 0)
            told.seconds = watch.seconds();
        finish(mode, how, before, report);
        return result;
    };
    try {
        return together(device->ranks(), work);
    } catch (...) {
        if (capacity && how.train > 0)
            abandon();
        else if (!capacity && guided) // it may be half of what was asked for
            drop();
        throw;
    }
}

template <class Run>
void Renderer::State::expose(const Work&, Mode mode, Film& film, const View& view, const PassOptions& how,
                             const std::vector<const std::vector<float>*>& input, PassReport* report, Run&& run) {
    requireSameOnAll(mode, view, how, input, film.samples());
    const auto work = [&] {
        const Before before = begin(mode, view, how);
        const double compiledBefore = device->device.compileSeconds();
        const std::lock_guard adding(film.state()->mutex);
        const Stopwatch watch;
        run(samplesOf(how), film.state()->film);
        told.seconds = watch.seconds() - (device->device.compileSeconds() - compiledBefore);
        finish(mode, how, before, report);
    };
    together(device->ranks(), work);
}

template <class Learn>
void Renderer::State::train(const Work&, Mode mode, const View& view, const PassOptions& how, const std::vector<const std::vector<float>*>& input,
                            Learn&& learn) {
    requireSameOnAll(mode, view, how, input);
    together(device->ranks(), [&] { ensure(mode, true, false); });
    if (!guided) // passes draw from the materials alone
        return;
    renderer->setInteraction(interaction());
    const std::uint32_t spp = how.trainSpp > 0 ? how.trainSpp : samplesOf(how);
    try {
        for (std::uint32_t i = 0; i < how.train; ++i) {
            together(device->ranks(), [&] { learn(spp, trained); });
            fresh = false;
            ++trained;
        }
    } catch (...) {
        if (capacity)
            abandon();
        else
            drop();
        throw;
    }
}

} // namespace cmpg::v1
