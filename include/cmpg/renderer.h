// Images of a scene, and their derivatives in forward and reverse mode.
#pragma once

#include <cmpg/device.h>
#include <cmpg/image.h>
#include <cmpg/options.h>
#include <cmpg/scene.h>

#include <functional>

namespace cmpg::v1 {

struct RendererOptions {
    PathOptions paths = {};
    std::vector<std::string> parameters = {}; // names or globs: what derivatives may be asked for, in this order
};

// What one pass makes.
struct PassOptions {
    std::string camera = {};   // empty: the first
    int width = 0, height = 0; // in pixels, at most 32768; 0: by the camera's aspect ratio from the other one; both 0: 512 wide
    std::uint32_t spp = 64;    // samples per pixel
    std::uint64_t seed = 0;    // equal seeds, equal random numbers; images and derivatives of one seed have independent ones
    // Learning passes before this one, of `trainSpp` samples per pixel (0: as many as the pass has). They learn a guide anew, from which this
    // pass and those after it draw.
    std::uint32_t train = 0, trainSpp = 0;
    // Derivatives with the random numbers of the image of this seed, equally many samples in every pixel and no guide: for comparison with
    // finite differences. In an optimisation their noise would be correlated with the image's. Error(Usage) together with `train`.
    bool frozen = false;
};

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
    Image render(const PassOptions& pass = {});

    // The derivative of the image along directions of parameters, summed: sum_i dI/dp_i . v_i, height x width x 3.
    Image forward(std::span<const Direction> directions, const PassOptions& pass = {});

    // adjoint^T . dI/dp of every parameter of the options, in their order: entries() each. `adjoint`: height x width x 3, the derivative of a
    // scalar by every pixel; the pass has its size, and PassOptions::width and height are 0 or agree.
    std::vector<std::vector<double>> backward(const Image& adjoint, const PassOptions& pass = {});

    std::vector<ParameterInfo> parameters() const; // of the options, globs expanded

    // Called from the thread of a pass, about five times a second. What it throws ends the pass, and nothing of it remains.
    void onSubmission(std::function<void()> call);

    struct State;

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1
