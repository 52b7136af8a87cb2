// A recovery put together: the model of the images and the optimisation, over a renderer and its passes, in the order in which they need each other.
#pragma once

#include "optimize/optimize.h"
#include "optimize/renderer_model.h"

#include <optional>

namespace cmpg {

class RecoveryRun {
  public:
    struct Steps {
        OptimizeConfig config;      // with a target per view
        std::vector<View> views;    // cameras outlive the run
        std::uint32_t freeze = ~0u; // step from which on the guide stays as it is
        // Puts a model of the caller's around the renderer's, which outlives it.
        std::function<std::unique_ptr<ImageModel>(ImageModel& inner)> wrap = {};
        OptimizeState start = {}; // as of Optimization's constructor
    };
    // All outlive it, but that its destructor does not use them; the scene holds the current values. `parameters`: the renderer's
    // RenderConfig::differentiable. Error(Input or Usage) as Optimization's constructor.
    RecoveryRun(Renderer& renderer, GuidedPasses& passes, Scene& scene, std::vector<std::uint32_t> parameters, Steps steps);
    RecoveryRun(const RecoveryRun&) = delete;

    // Compiles kernels of the next step, as it is decided now: the image's at once, those of the derivative pass meanwhile.
    void prepareStep();
    // How many kinds of passes of the next step have kernels that are not compiled: of images, of derivatives.
    std::uint32_t kindsToCompile() const;

    ImageModel& model() { return wrapped_ ? *wrapped_ : static_cast<ImageModel&>(model_); }
    Optimization& optimization() { return *optimization_; }
    const Optimization& optimization() const { return *optimization_; }

  private:
    GuidedPasses& passes_;
    Renderer::Mode imageMode_; // of the images that steps make
    RendererModel model_;
    std::unique_ptr<ImageModel> wrapped_;
    std::optional<Optimization> optimization_;
};

} // namespace cmpg
