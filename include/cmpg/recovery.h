// Recovers parameters of a scene from images of it.
#pragma once

#include <cmpg/device.h>
#include <cmpg/image.h>
#include <cmpg/film.h>
#include <cmpg/options.h>
#include <cmpg/renderer.h>
#include <cmpg/report.h>
#include <cmpg/scene.h>

#include <functional>
#include <utility>

namespace cmpg::v1 {

// What a camera saw. Images of the recovery have its size.
struct Target {
    std::string camera = {};      // empty: the first
    Image image = {};             // linear, 3 channels
    std::vector<float> mask = {}; // weight of each pixel in [0,1]; empty: 1 everywhere. Pixels that are not finite have weight 0
    std::vector<std::uint8_t> clipped = {}; // 1 for values that are lower bounds, since the picture is clipped there; empty: none
    std::string name = {};        // in messages; empty: its number
    // Where `image` has no values: gives all of the target, the same every time. Called at the start, and whenever a step sees it: so memory need not hold
    // the targets of many views.
    std::function<Target()> read = {};
    std::optional<CameraInfo> from = {}; // as PassOptions::from

    static constexpr std::size_t kMostBytes = std::size_t(256) << 20; // of values that the command line and Python hold, before they stream the rest

    // Reads .exr, .hdr, .png or .jpg. Alpha weights pixels, and so does the mean channel of the image `mask`; the largest
    // values of .png and .jpg are lower bounds. Pixels that are not finite have no weight. Values are multiplied by 2^exposure. Error(Input) where no pixel is left.
    static Target load(const std::filesystem::path& file, const std::string& camera = {}, const std::filesystem::path& mask = {}, float exposure = 0);
    // The same, but its values stay in the file: it has the image's size, and `read`.
    static Target stream(const std::filesystem::path& file, const std::string& camera = {}, const std::filesystem::path& mask = {}, float exposure = 0);

    // This target with fewer pixels, width x height; of an edge that is 0, as many as keep its shape. Pixels are means of what they cover, by the mask's weights; one
    // that covers a clipped value is a lower bound. What is streamed stays so. Error(Input) where the target has fewer pixels than that, or another shape.
    Target averaged(int width, int height = 0) const;
};

struct ImageLoss {
    double value = 0;            // weighted mean over pixels and channels
    Image adjoint = {};          // its derivative by every value of the image, in the image's shape: for Renderer::backward()
    std::uint64_t nonFinite = 0; // pixels left out because the image is not finite there
};
// Of an image as it is, with its noise; sums are in a fixed order. Error(Input) where the sizes differ or no pixel has a weight.
ImageLoss lossOf(Loss loss, const Image& image, const Target& target);

// Also of the command line's `optimize`, which has its defaults from here.
struct RecoveryOptions {
    PathOptions paths = {};
    std::vector<std::string> parameters = {}; // names or globs: what is recovered
    std::uint32_t steps = 200;                // of the schedule; step() may go beyond them where the rate is constant
    std::uint32_t spp = 16;                   // samples per pixel of the image of the first step
    std::uint32_t sppGradient = 4;            // of the derivative pass of a step
    // At most, that bring the image of the step before up to date: all where what is left of a squared loss is the image's noise, half where it is not
    // and steps are long, 2 where neither. 0: every step renders its own of `spp`; else 2 at least. Of all three numbers a pixel takes fewer, down to a
    // quarter, where Gauss-Newton recovers textures of colour or light alone, with a prior and without `errorTarget`, whose texels cover more than four pixels.
    std::uint32_t sppDifference = 12;
    std::uint64_t seed = 0;
    Loss loss = Loss::Mse;
    OptimizerKind optimizer = OptimizerKind::Auto;
    // Step per update, for a slot ("roughness") or, where the name is empty, for all; later ones win. Of emission and radiance in units of the
    // mean starting value. Slots without one have 0.02 (normal 0.01), of Sgd 0.5 (0.25).
    std::vector<std::pair<std::string, float>> rates = {};
    Schedule schedule = Schedule::Constant;
    float finalRate = 0.1f;         // what the schedule has multiplied rates by at the last step
    // Of textures: differences of neighbouring texels are as likely as exp(-prior n (d^3 / 4)^(1/4)), with d over n channels; `prior` is smaller for
    // textures of which a pixel sees more than three texels along its edge, and where they are in the shade. With one, textures of which all pixels cover four texels
    // or more along their shorter side step on a coarser grid by Gauss-Newton. 0: none.
    float prior = 8;
    float totalVariation = 0;       // weight of the total variation of textures
    // Of several targets, at most. 0: all; where Gauss-Newton recovers textures and no constants, of four and more at first one, and of fewer one by maps of
    // roughness and other shapes of lobes alone.
    std::uint32_t viewsPerStep = 0;
    std::uint32_t warmUp = 0;       // first steps, which only learn the guide
    std::uint32_t freeze = 0;       // step from which on the guide stays as it is; 0: none
    // The gradient of each step is sampled until |standard error| / |gradient| is this small, in batches; sppGradient is the most, and at least as large as
    // their number. 0: no target; from 1e-6 to 100.
    double errorTarget = 0;
    std::uint32_t batches = kFewestBatches; // of a gradient with an error target; from 8 to 64
};

// Of gradients with an error target.
struct GradientErrors {
    std::uint64_t gradients = 0, missed = 0; // the latter: those of the former whose error stayed too large
    double worst = 0;                        // error of these
};

// What happened beside what was asked for.
struct Warning {
    std::string event = {};                                     // its kind in one word: "gradients_stall"
    std::string text = {};                                      // with the remedy
    std::vector<std::string> options = {};                      // that the remedy is about: see Error
    std::vector<std::pair<std::string, double>> numbers = {};
};

struct RecoveryStep {
    std::uint32_t step = 0; // from 0
    // Mean over the views as steps saw them last, before the update, and its standard error. A squared loss has no bias by noise, so it may be negative.
    double loss = 0, lossError = 0;
    double regularizer = 0;     // weighted; no part of `loss`
    double rate = 0;            // of the first parameter, schedule included
    double seconds = 0;         // wall, of the whole step
    double imageSeconds = 0, gradientSeconds = 0, updateSeconds = 0; // of it; the last with loss and regulariser
    double compileSeconds = 0;  // of it, in which kernels were compiled, about; 0 in history()
    double gradientNorm = 0;    // Euclidean, over all parameters
    double concentration = 0;   // of the gradient: the share of the few largest paths in the sum of all squares; 0: not measured
    std::uint64_t paths = 0;    // from the camera, of image and gradient
    std::uint64_t dropped = 0;  // entries and pixels left out because they were not finite
    double nextSeconds = 0;     // that the next step is expected to take: as the last five, by its number of views and what it measures; and to compile what it lacks
    std::vector<Warning> warnings = {}; // gradients that explode, stall or come from a few samples, each told once
};

// What another recovery can go on from: the steps done, and what the optimiser knows of each parameter. A handle; null: nothing.
struct RecoveryProgress {
    struct State;
    std::shared_ptr<const State> state;
};

// A handle: copies are the same recovery.
class Recovery {
  public:
    // Takes a copy of the scene: its values are where the recovery begins, and stay as they are. Error(Input) where a target does not fit,
    // Error(Usage) on options that make no sense.
    Recovery(const Device& device, const Scene& scene, const std::vector<Target>& targets, const RecoveryOptions& options);

    // Of a renderer with RendererOptions::recoveries, for programs that look on. Its parameters are recovered, from the current values of its scene on. Each step
    // takes over what others have set there, and puts its own values there. Steps draw as the renderer's options say and learn its guide; the renderer's
    // passes between them draw from that. RecoveryOptions::paths and parameters are not read. `from`: goes on after these steps; parameters that were not
    // among them, have another size now or stepped by another method begin here, and all do where the loss or the targets are others. A renderer has one
    // recovery at a time: another ends it, and so do Renderer::setSampling, Renderer::forget, and new values of parameters that the renderer was not made
    // for, or another size of one that it was. Error(Usage) on a renderer that was not made for recoveries.
    Recovery(const Renderer& renderer, const std::vector<Target>& targets, const RecoveryOptions& options, const RecoveryProgress& from = {});
    bool ended() const; // its renderer was put to another use: steps, images and checkpoints throw Error(Usage), all else can be asked for
    RecoveryProgress progress() const;
    // Steps, images and checkpoints are refused with Error(Usage) where a call back of the renderer's own work asks for them.

    // Error(Numerical) where no entry of the gradient is finite, Error(Device) where the device is lost. Whatever ends it, the state is
    // that after a whole step.
    RecoveryStep step();
    // Makes kernels for the next step, which else makes them itself.
    void prepare();
    std::uint32_t steps() const; // done so far
    bool done() const;           // all of RecoveryOptions::steps
    // Of the steps done, those before resume() included: without warnings, paths, concentration and what comes next.
    std::vector<RecoveryStep> history() const;

    std::vector<ParameterInfo> parameters() const;
    // Current ones, and, as `info`, what the parameter is in that moment: new sizes end a recovery. Error(Usage) for what is not recovered.
    std::vector<float> values(const std::string& parameter, ParameterInfo* info = nullptr) const;
    // Of the last step, regulariser and weights of noisy pixels included, in the size with which the recovery began; zeros before the first.
    std::vector<double> gradient(const std::string& parameter) const;
    GradientErrors errors() const; // of the steps so far
    // What all passes since the recovery was made cost and left out, and how directions are drawn now. Of its seconds, those of learning.
    PassReport report() const;
    Image target(std::size_t target = 0) const; // what steps compare with: the image that was given
    // `image`, of the target's size, less the target, as steps see it: 0 where the target has no weight, or is clipped and the image is no darker.
    Image difference(const Image& image, std::size_t target = 0) const;
    // Of a target's camera, with the same random numbers whatever the step: at the current values, or at those where the recovery began.
    Image image(std::size_t target = 0, std::uint32_t spp = 64, bool initial = false);
    // Adds `spp` samples per pixel of that image, at the current values, to a film of the target's size.
    void image(Film& film, std::size_t target = 0, std::uint32_t spp = 64, PassReport* report = nullptr);

    // For the steps to come: samples per pixel of images and derivative passes, as RecoveryOptions has them, and a factor on all rates, from 0 to 1e6, beside
    // the schedule. Checkpoints have neither: who resumes a recovery sets them again.
    void setSamples(std::uint32_t spp, std::uint32_t sppGradient);
    void setRateFactor(double factor);

    // Puts the current values into a scene: that it was made of, or a copy of it.
    void apply(Scene& scene) const;

    // Writes all that resume() needs to `folder`, and keeps the one before. `note`: a text of the caller's, kept with it. Returns the number of bytes. Of
    // several ranks the first writes it, and the others return 0.
    // Error(Output) where that fails.
    std::uint64_t save(const std::filesystem::path& folder, const std::string& note = {}) const;
    // Continues from the last one that can be read, to what the saved recovery would have found, bit for bit on the same device. False where
    // the folder has none. Error(Input) where none can be read, or where it is of another scene or target; Error(Usage) where options differ. The
    // first difference is named. `warnings`: a newer one that cannot be read, another device.
    bool resume(const std::filesystem::path& folder, std::vector<Warning>* warnings = nullptr);
    // The note of the one that resume() continues from; none where the folder has none. Error(Input) where none can be read.
    static std::optional<std::string> note(const std::filesystem::path& folder);
    // Renames the newest checkpoint of a folder, so that resume() finds none there: before another run begins in it. Returns the new name, empty where there
    // was none. Error(Output) where that fails.
    static std::filesystem::path setAside(const std::filesystem::path& folder);

    // Writes what was learned, for GuideOptions::load. Error(Usage) where nothing is learned, Error(Output) where it cannot be written.
    void saveGuide(const std::filesystem::path& file) const;

    // As Renderer::onSubmission, and that of its renderer where it has one. A step that it ends has changed nothing and can be done again.
    void onSubmission(std::function<void()> call, double seconds = 0.2);
    // Called with each image that a step compares with a target, from the thread of the step. It may ask for no work of the renderer, as in Renderer::onSubmission.
    void onImage(std::function<void(std::size_t target, const Image& image)> call);

    struct State;

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
