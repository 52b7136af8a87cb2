// What a session does with a scene: films that refine, learning passes, steps. One piece at a time.
#pragma once

#include "live/loaded_scene.h"
#include "live/refined.h"

#include <optional>

namespace cmpg {

// Thrown between two submissions of a pass that is of no more use.
struct LiveInterrupted {};

class LiveWork {
  public:
    struct Hooks {
        std::function<void()> betweenSubmissions;  // may throw LiveInterrupted
        std::function<void()> afterPreview;        // the same, whether or not anything came since
        std::function<void(const char*)> busyWith; // what takes a while begins; "": it is over
        std::function<void()> publish;             // the state changed in the midst of a piece of work
    };
    // `state` gets pictures and numbers.
    LiveWork(const Options& options, const v1::Device& device, LoadedScene& scene, LiveState& state, Hooks hooks);

    const LiveSettings& settings() const { return settings_; }
    // Settings that make sense for this scene.
    LiveSettings sanitised(LiveSettings settings) const;
    void setSettings(const LiveSettings& settings);
    // Whether steps towards targets are what such settings ask for, seen by the cameras of the targets.
    static bool optimizes(const LiveSettings& settings, std::size_t views) {
        return settings.mode == LiveMode::Optimize && !settings.parameters.empty() && views > 0;
    }
    // Whether a pass under way would be of no more use with other settings.
    bool outdates(const LiveSettings& wished) const;

    void addSteps(std::uint32_t steps) { steps_ += steps; }
    void addTraining(std::uint32_t passes) { training_ += passes; }
    void targetsChanged();
    void reset(std::optional<float> fill); // to the scene's values, or the selected parameters to one value

    bool hasWork() const;
    std::string missing() const; // why there is nothing new to see, for the notice; empty: there is
    // Some tenths of a second of work, or one step.
    void work();
    // After an exception out of work(): as if the piece had not begun.
    void recover() { previewing_ = false; }
    // After one that the device is to blame for: the values stay, and all that was on the device goes. The work goes on with another one.
    void leaveDevice();
    void setDevice(const v1::Device& device) { device_ = device; }

    LivePick pick(int x, int y) const; // a pixel of the image

  private:
    // Of the pictures.
    struct Seen {
        v1::CameraInfo camera;
        int width = 0, height = 0;
    };
    Seen seen() const;
    bool optimizing() const { return optimizes(settings_, scene_.views()); }
    bool differentiating() const { return settings_.mode != LiveMode::Render && !settings_.parameters.empty(); }
    bool unfinished(const Refined& film) const;

    void ensureRenderer();
    void ensureRecovery();
    void dropRecovery(bool keepProgress);
    void dropRenderer();
    void restartFilms();
    v1::PassReport report() const; // of all passes of the renderer
    v1::PassOptions pass(std::uint32_t spp, std::uint32_t frame = 0) const;

    void refine(Refined& film, bool forward);
    double expose(std::uint32_t spp, v1::Film& film, bool forward, std::uint32_t frame = 0); // seconds that it took
    bool previewed(Refined& film, bool forward);
    void train();
    void step();
    bool outdoesCarried(const v1::Film& film); // by its noise
    bool carriesImages() const { return options_.recovery.sppDifference > 0; }
    void fadeGradient();

    void show(LivePicture picture, std::shared_ptr<const Image> image);
    void showImage(Image image);
    void showLayers(const v1::Film& film);
    void showParameter();
    void updateGuideFigures();

    const Options options_;
    std::optional<v1::Device> device_;
    LoadedScene& scene_;
    LiveState& state_;
    Hooks hooks_;
    LiveSettings settings_;
    bool applied_ = false;                  // settings_ were set once
    std::vector<v1::Direction> directions_; // of the selected parameters: all ones

    std::vector<std::uint32_t> builtFor_; // parameters that renderer_ differentiates
    Sampling drawnBy_ = Sampling::Auto;   // its passes
    std::optional<v1::Renderer> renderer_;
    std::optional<v1::Recovery> recovery_; // of renderer_
    v1::RecoveryProgress progress_;        // of a recovery that had to go, for the next one

    Refined image_, gradient_;
    Image earlier_; // of image_, when it had earlierSamples_: how far it changed since tells its noise
    std::uint32_t earlierSamples_ = 0;
    Image fading_; // mean of the gradient images of the last steps
    std::uint32_t fadingSteps_ = 0;
    bool previewing_ = false;
    std::uint32_t steps_ = 0, training_ = 0; // asked for
    std::vector<double> loss_;
    std::uint64_t drawnBefore_ = 0, guidedBefore_ = 0; // directions, when the films began
};

} // namespace cmpg
