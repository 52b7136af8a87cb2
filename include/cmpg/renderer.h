// Images of a scene, and their derivatives in forward and reverse mode.
#pragma once

#include <cmpg/check.h>
#include <cmpg/device.h>
#include <cmpg/film.h>
#include <cmpg/image.h>
#include <cmpg/options.h>
#include <cmpg/report.h>
#include <cmpg/scene.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cmpg::v1 {

struct RendererOptions {
    PathOptions paths = {};
    std::vector<std::string> parameters = {}; // names or globs: what derivatives may be asked for, in this order
    // For programs that render, learn, differentiate and recover in turn: there is room for all of it from the start, so that a guide outlives what comes
    // next, and recoveries can be made of the renderer. It takes more memory than a renderer that is made for what passes ask for.
    bool recoveries = false;
};

// Samples per pixel of each of `passes` learning passes before a pass of `spp`, where nothing else is asked for: together as many as it has, but four each, or
// `spp` if that is less. Before several batches, whose number of samples is not known yet, eight.
inline std::uint32_t learningSamples(std::uint32_t spp, std::uint32_t passes, std::uint32_t batches) {
    constexpr std::uint32_t kFewest = 4, kBatched = 8;
    if (batches > 0)
        return kBatched;
    const std::uint32_t part = passes > 0 ? spp / passes + (spp % passes > 0 ? 1 : 0) : spp;
    return std::min(spp, std::max(part, kFewest));
}

// What one pass makes.
struct PassOptions {
    std::string camera = {};   // empty: the first
    // The camera of this name, else the first, moved: with this pose, kind, angle and height in place of the file's. `camera` is not read then. Error(Usage)
    // where they are not finite or out of range.
    std::optional<CameraInfo> from = {};
    int width = 0, height = 0; // in pixels, at most 32768; 0: by the camera's aspect ratio from the other one; both 0: a Mitsuba film's size, else 512 wide
    std::uint32_t spp = 0;     // samples per pixel; 0: 64, or up to 65536 under an error target or a time budget
    std::uint64_t seed = 0;    // equal seeds, equal random numbers; images and derivatives of one seed have independent ones
    std::uint32_t frame = 0;   // passes of one seed and different frames have independent random numbers
    // Learning passes before this one, of `trainSpp` samples per pixel (0: learningSamples()). They
    // learn a guide anew, or continue that of GuideOptions::load, and this pass and those after it draw from it.
    std::uint32_t train = 0, trainSpp = 0;
    bool anew = true; // false: they continue what passes of this renderer have learned, if its guide can be kept
    // Derivatives with the random numbers of the image of this seed, equally many samples in every pixel and no guide: for comparison with
    // finite differences. In an optimisation their noise would be correlated with the image's. Error(Usage) together with `train`.
    bool frozen = false;

    // Sample until the error is small enough or the time is up: in batches with random numbers of their own, whose spread tells the error
    // (PassReport::error). They grow together, so `spp`, the most in all, is divided among them.
    double errorTarget = 0;    // |standard error| / |estimate|, over all pixels or texels; 0: none; from 1e-6 to 100
    double timeBudget = 0;     // seconds, learning included; 0: none. The first stage, of a sample a batch, runs in any case
    std::uint32_t batches = 0; // from 8 to 64; 0: 8 with a target or budget, else samples are not divided

    bool layers = false; // PassReport::layers; of render() and forward(), not in batches, nor of positivised derivatives
    // Where more than one path in a hundred was left out because it was not finite: Error(Numerical). False: PassReport::dropped alone tells.
    bool strict = true;
    // Called with the image as it grows, now and then; of render() and forward(). The result is the same. As onSubmission() it may ask for no other work.
    std::function<void(const Image& image)> onImage = {};
};

enum class PassKind { Render, Forward, Backward };

// A direction in the space of one parameter.
struct Direction {
    std::string parameter = {};
    std::vector<float> values = {}; // entries() of them
};

// What the guide knows at a point. Its three parts: P, light; D+ and D-, the positive and the negative terms of its derivatives.
struct GuidePoint {
    std::uint32_t cell = 0, cells = 0;  // the number of the point's cell, and how many there are
    double records = 0;                 // that the cell has learned from; those of old passes count less
    double weight = 0;                  // the same, faded since the cell learned last
    std::array<double, 3> means = {};   // of the parts, per record
    // Of the parts in the mixture for a path that arrives straight from the camera. By conditional sampling such a path has collected no derivative yet, so it
    // asks for what carries derivatives.
    std::array<double, 3> weights = {};
    double lightShare = 0; // of P in that mixture; D has the rest
    double guideShare = 0; // of directions that are drawn from the mixture, where the material is rough enough: 0 where it is empty

    // The density of a mixture of the parts over that of uniform directions, on the equal-area square of all directions: azimuth across, z up, row 0 is z = 1.
    // edge x edge x 1, mean over each pixel; all 0 where the mixture is empty. `edge`: a power of two, from 2 to 4096.
    Image density(const std::array<double, 3>& mixture, int edge) const;

    struct State;
    std::shared_ptr<const State> state; // of the cell, as it was
};

// What a renderer takes for passes of some kinds.
struct Footprint {
    struct Kernel {
        PassKind kind = PassKind::Render; // of the passes that it is for
        std::string name = {};
        std::uint64_t bytes = 0, moduleBytes = 0; // of SPIR-V: specialised for the scene, and as it is for all scenes
    };
    std::vector<std::pair<std::string, std::string>> features = {}; // what kernels are made for, by name: "on", "off" or what it is
    std::vector<Kernel> kernels = {};
    std::map<std::string, std::uint64_t> buffers = {}; // bytes of device memory, by what is in them
};

// A handle: copies are the same renderer. Passes of one renderer follow one another. They throw Error(Usage) on options out of range and unknown
// names, Error(Device) where memory is short or the device is lost, and Error(Numerical) where more than one path in a hundred was left out
// because it was not finite.
class Renderer {
  public:
    // The scene's values are read at every pass. Those of RendererOptions::parameters may change at little cost; a change of any other has the
    // renderer made anew, without its guide. Error(Usage) on unknown parameters and options out of range.
    Renderer(const Device& device, const Scene& scene, const RendererOptions& options = {});

    // Radiance, height x width x 3, linear.
    Image render(const PassOptions& pass = {}, PassReport* report = nullptr);

    // The derivative of the image along directions of parameters, summed: sum_i dI/dp_i . v_i, height x width x 3.
    Image forward(std::span<const Direction> directions, const PassOptions& pass = {}, PassReport* report = nullptr);

    // The same for films, which have the pass's size: adds `spp` samples per pixel, those that follow the film's in the sequence of the pass's random numbers. They
    // are drawn by what was found best so far, and nothing is learned from them. A pass that ends early leaves the film as it was. For passes of one film, all
    // else is equal: values, camera, seed, frame and directions. Never positivised, frozen or in batches, and with no learning passes; `onImage` and
    // `layers` are not read. Seconds of the report are without compilation.
    void render(Film& film, const PassOptions& pass = {}, PassReport* report = nullptr);
    void forward(Film& film, std::span<const Direction> directions, const PassOptions& pass = {}, PassReport* report = nullptr);

    // `pass.train` learning passes alone, of `pass.trainSpp` (0: spp) samples per pixel, for images, or for derivatives along directions. They go on from all that
    // these two have learned so far, with random numbers of their own. What ends one of them leaves the guide to what whole ones have learned, with
    // RendererOptions::recoveries; else the guide forgets.
    void train(const PassOptions& pass);
    void train(std::span<const Direction> directions, const PassOptions& pass);
    void forget(); // all that the guide has learned
    // Directions are drawn otherwise from here on, by the guide as it is. Needs RendererOptions::recoveries.
    void setSampling(Sampling sampling);

    // adjoint^T . dI/dp of every parameter of the options, in their order: entries() each. `adjoint`: height x width x 3, the derivative of a
    // scalar by every pixel; the pass has its size, and PassOptions::width and height are 0 or agree.
    std::vector<std::vector<double>> backward(const Image& adjoint, const PassOptions& pass = {}, PassReport* report = nullptr);

    // forward() along one direction against finite differences of images, whose paths are drawn at the current values: 16 times each, with the probability
    // that they differ by chance. Takes 16 derivative passes of `sppGradient` and up to 200 images of `pass.spp` (0: 16) samples per pixel.
    CheckResult check(const Direction& direction, const PassOptions& pass = {}, std::uint32_t sppGradient = 0, PassReport* report = nullptr);

    // Makes kernels and buffers for passes of these kinds and options, so that none has to: else the first pass does.
    void prepare(std::initializer_list<PassKind> kinds, const PassOptions& pass = {});

    // What a renderer with these options would take for such passes; with learning passes before them, for those too and for the guide. Its buffers
    // are allocated beside those of this one and freed again, nothing is compiled. Error(Device) where memory is short.
    Footprint footprint(const std::vector<PassKind>& kinds, const PassOptions& pass = {});

    // Writes what was learned, for GuideOptions::load. Error(Usage) where nothing was, Error(Output) where it cannot be written.
    void saveGuide(const std::filesystem::path& file) const;

    std::vector<ParameterInfo> parameters() const; // of the options, globs expanded

    // What all passes since the renderer was made cost and left out, recoveries' included, and how passes of a kind are drawn now. Of its seconds, those of
    // learning. Without samples, errors and layers.
    PassReport report(PassKind kind = PassKind::Render) const;
    // What the guide knows at a point of the scene, for passes of a kind; none where it has learned nothing yet. Where passes draw without a guide the mixture is
    // that of conditional sampling. May be asked for in the midst of a pass, from its thread.
    std::optional<GuidePoint> guideAt(const std::array<float, 3>& position, PassKind kind) const;
    // The number of the guide's cell at the first surface of every pixel, height x width x 1; -1 where there is none. `depth`: Layers::depth of the pass. None where
    // the guide has learned nothing yet.
    std::optional<Image> guideCells(const Image& depth, const PassOptions& pass) const;

    // Called from the thread of a pass, before every submission; one takes about `seconds`, from 0.001 to 10: 0.02 for what somebody waits for. Results do not
    // depend on it. What it throws ends the pass, and nothing of it remains. It may ask this renderer for what is known, as report() and guideAt(): passes, and steps
    // of recoveries with this renderer, are refused with Error(Usage), since one is under way.
    void onSubmission(std::function<void()> call, double seconds = 0.2);
    // Called where a pass has to compile kernels, before and after.
    void onCompile(std::function<void(bool begins)> call);

    struct State;
    const std::shared_ptr<State>& state() const { return state_; }

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
