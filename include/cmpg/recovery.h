// Recovers parameters of a scene from images of it.
#pragma once

#include <cmpg/device.h>
#include <cmpg/image.h>
#include <cmpg/options.h>
#include <cmpg/scene.h>

#include <functional>
#include <utility>

namespace cmpg::v1 {

// What a camera saw. Images of the recovery have its size.
struct Target {
    std::string camera = {};      // empty: the first
    Image image = {};             // linear, 3 channels
    std::vector<float> mask = {}; // weight of each pixel in [0,1]; empty: 1 everywhere. Pixels that are not finite have weight 0

    // Reads .exr, .hdr, .png or .jpg. Alpha weights pixels, and so does the mean channel of the image `mask`; clipped pixels of 8-bit files
    // have weight 0. Values are multiplied by 2^exposure. Error(Input) where no pixel is left.
    static Target load(const std::filesystem::path& file, const std::string& camera = {}, const std::filesystem::path& mask = {}, float exposure = 0);
};

// Also of the command line's `optimize`, which has its defaults from here.
struct RecoveryOptions {
    PathOptions paths = {};
    std::vector<std::string> parameters = {}; // names or globs: what is recovered
    std::uint32_t steps = 200;                // of the schedule; step() may go beyond them where the rate is constant
    std::uint32_t spp = 16;                   // samples per pixel of the image of the first step
    std::uint32_t sppGradient = 4;            // of the derivative pass of a step
    // That bring the image of the step before up to date, at least 2; 0: every step renders its own of `spp`.
    std::uint32_t sppDifference = 8;
    std::uint64_t seed = 0;
    Loss loss = Loss::Mse;
    OptimizerKind optimizer = OptimizerKind::Auto;
    // Step per update, for a slot ("roughness") or, where the name is empty, for all; later ones win. Of emission and radiance in units of the
    // mean starting value. Slots without one have 0.02 (normal 0.01), of Sgd 0.5 (0.25).
    std::vector<std::pair<std::string, float>> rates = {};
    Schedule schedule = Schedule::Constant;
    float finalRate = 0.1f;         // what the schedule has multiplied rates by at the last step
    float prior = 8;                // of textures: differences of neighbouring texels are as likely as exp(-prior n d), with d over n channels; 0: none
    float totalVariation = 0;       // weight of the total variation of textures
    std::uint32_t viewsPerStep = 0; // of several targets; 0: all
    std::uint32_t warmUp = 0;       // first steps, which only learn the guide
    std::uint32_t freeze = 0;       // step from which on the guide stays as it is; 0: none
    // The gradient of each step is sampled until |standard error| / |gradient| is this small, in 8 batches; sppGradient, at least 8, is the most. 0: no
    // target; from 1e-6 to 100.
    double errorTarget = 0;
};

// Of gradients with an error target.
struct GradientErrors {
    std::uint64_t gradients = 0, missed = 0; // the latter: those of the former whose error stayed too large
    double worst = 0;                        // error of these
};

struct RecoveryStep {
    std::uint32_t step = 0; // from 0
    // Mean over the views, before the update, and its standard error. A squared loss has no bias by noise, so it may be negative.
    double loss = 0, lossError = 0;
    double regularizer = 0;     // weighted; no part of `loss`
    double rate = 0;            // of the first parameter, schedule included
    double seconds = 0;         // wall, of the whole step
    double gradientNorm = 0;    // Euclidean, over all parameters
    std::uint64_t dropped = 0;  // entries and pixels left out because they were not finite
    std::vector<std::string> warnings = {}; // gradients that explode, stall or come from a few samples, each told once
};

// A handle: copies are the same recovery.
class Recovery {
  public:
    // Takes a copy of the scene: its values are where the recovery begins, and stay as they are. Error(Input) where a target does not fit,
    // Error(Usage) on options that make no sense.
    Recovery(const Device& device, const Scene& scene, const std::vector<Target>& targets, const RecoveryOptions& options);

    // Error(Numerical) where no entry of the gradient is finite, Error(Device) where the device is lost. Whatever ends it, the state is
    // that after a whole step.
    RecoveryStep step();
    std::uint32_t steps() const; // done so far
    bool done() const;           // all of RecoveryOptions::steps

    std::vector<ParameterInfo> parameters() const;
    std::vector<float> values(const std::string& parameter) const;     // current ones; Error(Usage) for what is not recovered
    std::vector<double> gradient(const std::string& parameter) const;  // of the last step, regulariser included; zeros before the first
    GradientErrors errors() const; // of the steps so far
    // Of a target's camera at the current values, with the same random numbers whatever the step.
    Image image(std::size_t target = 0, std::uint32_t spp = 64);

    // Puts the current values into a scene: that it was made of, or a copy of it.
    void apply(Scene& scene) const;

    // Writes all that resume() needs to `folder`, and keeps the one before. Error(Output) where that fails.
    void save(const std::filesystem::path& folder) const;
    // Continues from the last one that can be read, to what the saved recovery would have found, bit for bit on the same device. False where
    // the folder has none. Error(Input) where it is of another recovery: the first difference is named.
    bool resume(const std::filesystem::path& folder);

    // Writes what was learned, for GuideOptions::load. Error(Usage) where nothing is learned, Error(Output) where it cannot be written.
    void saveGuide(const std::filesystem::path& file) const;

    // As Renderer::onSubmission. A step that it ends has changed nothing and can be done again.
    void onSubmission(std::function<void()> call);

    struct State;

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
