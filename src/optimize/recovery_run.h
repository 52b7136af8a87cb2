// A recovery put together: renderer, guided passes, the model of the images and the optimisation, in the order in which they need each other.
#pragma once

#include "optimize/optimize.h"
#include "optimize/renderer_model.h"

#include <optional>

namespace cmpg {

class RecoveryRun {
  public:
    // Both outlive it; the scene holds the current values. RenderConfig::differentiable is what is recovered.
    RecoveryRun(Device& device, Scene& scene, const RenderConfig& config, const GuidedOptions& guided);
    RecoveryRun(const RecoveryRun&) = delete;

    struct Steps {
        OptimizeConfig config;      // with a target per view
        std::vector<View> views;    // cameras outlive the run
        bool learn = false;         // from the steps' own passes; needs RenderConfig::guiding
        std::uint32_t freeze = ~0u; // step from which on the guide stays as it is
        // Puts a model of the caller's around the renderer's, which outlives it.
        std::function<std::unique_ptr<ImageModel>(ImageModel& inner)> wrap = {};
        OptimizeState start = {}; // as of Optimization's constructor
    };
    // In place of the optimisation before. Error(Input or Usage) as Optimization's constructor.
    void begin(Steps steps);
    void end(); // of the optimisation
    // Draws otherwise from here on: by the guide as it is where it is `kept`, else by one that has learned nothing. Ends the optimisation.
    void setGuided(const GuidedOptions& guided, bool kept);
    // Compiles kernels of the next step, as it is decided now: the image's at once, those of the derivative pass meanwhile.
    void prepareStep();

    Renderer& renderer() { return renderer_; }
    const Renderer& renderer() const { return renderer_; }
    GuidedPasses& passes() { return *passes_; }
    const GuidedPasses& passes() const { return *passes_; }
    bool begun() const { return optimization_.has_value(); }
    // After begin():
    Renderer::Mode imageMode() const { return imageMode_; } // of the images that steps make
    ImageModel& model() { return wrapped_ ? *wrapped_ : static_cast<ImageModel&>(*model_); }
    Optimization& optimization() { return *optimization_; }
    const Optimization& optimization() const { return *optimization_; }

  private:
    Scene& scene_;
    std::vector<std::uint32_t> parameters_;
    Renderer renderer_;
    std::optional<GuidedPasses> passes_;
    Renderer::Mode imageMode_ = Renderer::Mode::Render;
    std::optional<RendererModel> model_;
    std::unique_ptr<ImageModel> wrapped_;
    std::optional<Optimization> optimization_;
};

} // namespace cmpg
