// Images of a scene, and their derivatives in forward and reverse mode.
#pragma once

#include <cmpg/check.h>
#include <cmpg/device.h>
#include <cmpg/image.h>
#include <cmpg/options.h>
#include <cmpg/report.h>
#include <cmpg/scene.h>

#include <functional>
#include <initializer_list>

namespace cmpg::v1 {

struct RendererOptions {
    PathOptions paths = {};
    std::vector<std::string> parameters = {}; // names or globs: what derivatives may be asked for, in this order
};

// What one pass makes.
struct PassOptions {
    std::string camera = {};   // empty: the first
    int width = 0, height = 0; // in pixels, at most 32768; 0: by the camera's aspect ratio from the other one; both 0: 512 wide
    std::uint32_t spp = 0;     // samples per pixel; 0: 64, or up to 65536 under an error target or a time budget
    std::uint64_t seed = 0;    // equal seeds, equal random numbers; images and derivatives of one seed have independent ones
    // Learning passes before this one, of `trainSpp` samples per pixel (0: as many as the pass has; of several batches 8). They
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
    // Called with the image as it grows, now and then; of render() and forward(). The result is the same.
    std::function<void(const Image& image)> onImage = {};
};

enum class PassKind { Render, Forward, Backward };

// A direction in the space of one parameter.
struct Direction {
    std::string parameter = {};
    std::vector<float> values = {}; // entries() of them
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

    // adjoint^T . dI/dp of every parameter of the options, in their order: entries() each. `adjoint`: height x width x 3, the derivative of a
    // scalar by every pixel; the pass has its size, and PassOptions::width and height are 0 or agree.
    std::vector<std::vector<double>> backward(const Image& adjoint, const PassOptions& pass = {}, PassReport* report = nullptr);

    // forward() along one direction against finite differences of render(), 16 times each, with the probability that they differ by chance
    // (docs/numerics.md). Takes 16 derivative passes of `sppGradient` and up to 200 images of `pass.spp` (0: 16) samples per pixel.
    CheckResult check(const Direction& direction, const PassOptions& pass = {}, std::uint32_t sppGradient = 0, PassReport* report = nullptr);

    // Makes kernels and buffers for passes of these kinds and options, so that none has to: else the first pass does.
    void prepare(std::initializer_list<PassKind> kinds, const PassOptions& pass = {});

    // Writes what was learned, for GuideOptions::load. Error(Usage) where nothing was, Error(Output) where it cannot be written.
    void saveGuide(const std::filesystem::path& file) const;

    std::vector<ParameterInfo> parameters() const; // of the options, globs expanded

    // Called from the thread of a pass, about five times a second. What it throws ends the pass, and nothing of it remains.
    void onSubmission(std::function<void()> call);

    struct State;

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
