// An optimisation: parameters of a scene move until its images match their targets.
#pragma once

#include "optimize/coarse_texture.h"
#include "optimize/constant_block.h"
#include "optimize/coupled_maps.h"
#include "optimize/gauss_newton.h"
#include "optimize/image_model.h"
#include "optimize/losses.h"
#include "optimize/optimizer.h"
#include "optimize/pixel_shares.h"
#include "optimize/regularizer.h"
#include "optimize/running_image.h"
#include "optimize/target.h"
#include "optimize/texel_footprint.h"
#include "optimize/view_order.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

namespace cmpg {

struct OptimizeConfig {
    std::uint32_t steps = 200;
    std::uint32_t spp = 16, sppGradient = 4; // per pixel and step, of the primal and of the derivative pass
    // Per pixel, at most, of the steps that carry the image of the step before on (RunningImage), two at least; 0: every step renders its own of `spp`. As
    // many where what is left of a squared loss is the image's noise, half of them where it is not and gradients are signal, two where neither.
    std::uint32_t sppDifference = 2;
    double sampleShare = 1; // of these numbers that a pixel takes, two samples at least (texel_footprint.h)
    std::uint64_t seed = 0;
    Loss loss = Loss::Mse;
    // Gauss-Newton needs a squared loss and images that steps carry on, and takes derivative passes in halves. Some steps measure the curvature first, which
    // costs about a step more. Constants step together, by the whole matrix of their curvature (constant_block.h), if they are few, and so do maps of one
    // material, by a block for each texel (coupled_maps.h).
    OptimizerConfig optimizer;
    double totalVariation = 0; // weight of the regulariser; 0 = off
    // What is known of textures before any image: differences of neighbouring texels are distributed as exp(-prior n d), with n channels and d the root mean
    // square of theirs, that of light in units of its mean. Images say exp(-n loss / tolerated), over their n values: errors of 10 % of the target's mean are likely,
    // or, with a squared loss, errors as large as there are where those are smaller. What is recovered is the most likely texture under both (maximum a
    // posteriori). 0: any texture is as likely.
    double prior = 0;
    // Of the parameters; empty: of none. The prior of finer textures is weaker. Those of which a pixel covers many texels step on a coarser grid, whose texels are
    // half of what it covers at most, by Gauss-Newton.
    std::vector<TexelFootprint> footprints{};
    // So many views a step, in random order, whose mean loss stands for that of all. 0: all; where Gauss-Newton recovers textures, without constants, from four
    // views or more, one at first and more later (ViewOrder), and from fewer one where all textures are of shapes of lobes.
    std::uint32_t viewsPerStep = 0;
    // Of the images that steps carry on, and the values that they are of. Images of views beyond it begin anew in every step that sees these.
    std::size_t imageBytes = std::size_t(1) << 30;
    std::uint32_t warmUp = 0;  // first steps, which leave the parameters alone: the model learns
    std::vector<Target> targets;             // one per view of the model
    std::function<void(std::size_t view, const Image& image)> onImage{}; // the image that a step compares with its target
};

// Whether steps carry images on.
inline bool carriesImages(const OptimizeConfig& config) { return config.sppDifference > 0; }

// Whether an optimisation has what Gauss-Newton needs.
inline bool allowsNewton(const OptimizeConfig& config) { return carriesImages(config) && isSquared(config.loss); }
// What a parameter of a slot steps by.
inline OptimizerKind methodOf(const OptimizeConfig& config, SlotKind kind) { return methodOf(config.optimizer.kind, kind, allowsNewton(config)); }

struct StepReport {
    std::uint32_t step = 0;     // from 0
    double loss = 0;            // mean over the views as steps saw them last, before the update; without bias by noise where the loss is a squared one
    double lossError = 0;       // its standard error by noise
    double regularizer = 0;     // weighted; not part of `loss`
    double rate = 0;            // of the first parameter, schedule included
    double secondsPrimal = 0, secondsGradient = 0, secondsUpdate = 0; // wall; update includes loss, regulariser, upload
    std::vector<double> gradientNorm; // Euclidean, per parameter, finite entries only
    double concentration = 0;         // of the derivative passes: see ImageModel
    std::uint64_t samples = 0;        // camera paths of both passes
    std::uint64_t dropped = 0;        // gradient entries and pixels left out because they were not finite
};

// What is kept of a step for good.
struct StepRecord {
    double loss = 0, lossError = 0, regularizer = 0, rate = 0; // as in StepReport, like the rest
    double secondsPrimal = 0, secondsGradient = 0, secondsUpdate = 0;
    double gradientNorm = 0; // over all parameters
    std::uint64_t dropped = 0;
};
StepRecord recordOf(const StepReport& report);

// Of a view, where a step saw it last.
struct ViewLoss {
    double value = 0, error = 0;
    bool known = false;
};

// Values of all parameters at a step, which views may share.
struct StepValues {
    std::vector<std::vector<float>> values;
};
using SharedValues = std::shared_ptr<const StepValues>;

// All that changes from step to step and is not in Scene::parameters.
struct OptimizeState {
    std::uint32_t step = 0; // steps done
    std::vector<Moments> moments;
    std::vector<StepRecord> history{}; // of the steps since 0, or since the run that this one goes on from
    std::vector<RunningImage> images{};             // of the views; empty before the first step, or where nothing is carried on
    std::vector<SharedValues> imageValues{};        // of the views: of the parameters, for which the image was made; null where there is none yet
    std::vector<std::vector<float>> pixelShares{};  // of the views: by pixel, of the samples of images, 1 on average; empty: all alike
    ConstantCurvature constants{};                  // of those that step together
    CarriedGradient carried{};                      // and their gradient
    std::vector<CrossCurvature> cross{};            // of the maps that step together (Optimization::coupled_)
    std::vector<ViewLoss> losses{};                 // of the views; empty before the first step
};

// Random numbers of the image of a view that is made to be looked at: of no step.
PassKey pictureKey(std::uint64_t seed, std::size_t view);
// And of what measures the curvature in a step.
PassKey curvatureKey(std::uint64_t seed, std::uint32_t step);
// And of what tries the shape of a lobe after one.
PassKey scanKey(std::uint64_t seed, std::uint32_t step);

class Optimization {
  public:
    // `parameters`: indices into scene.parameters, which hold the current values after every step. Error(Input) if a view
    // and its target do not fit, Error(Usage) if Gauss-Newton is asked for and lacks what it needs. `start`: to go on from another run; its moments are those of `parameters`.
    Optimization(ImageModel& model, Scene& scene, OptimizeConfig config, std::vector<std::uint32_t> parameters, OptimizeState start = {});

    // Now and then the curvature of the loss, once for each group of slots. For each view of the step: primal image, loss, adjoint, derivative pass with random numbers of its own; regulariser; then the model learns;
    // update, projection; now and then the shape of a lobe is tried over its range. Error(Numerical) if no gradient entry at all is finite. Whatever it throws, the state on the host is that
    // after a whole step, this one or the last: the device has no part in what changes it. But not where memory runs out in the update itself.
    StepReport step();
    double nextWork() const; // of the next step, about: in passes of one view
    // To go on where another run of the same parameters was after a step: with its values and gradients, which fit.
    void restore(OptimizeState state, const std::vector<std::vector<float>>& values, std::vector<std::vector<double>> gradients);
    // Error(Input) if they do not.
    void requireFits(const OptimizeState& state, const std::vector<std::vector<float>>& values, const std::vector<std::vector<double>>& gradients) const;

    // Image of a view at the current parameters, with the same random numbers whatever the step: two of them differ by what the
    // parameters changed, not by noise. By the kernels of the steps' images, which are compiled.
    Image render(std::size_t view, std::uint32_t spp);

    // For the steps to come.
    void setSamples(std::uint32_t spp, std::uint32_t sppGradient);
    void setRateFactor(double factor) { rateFactor_ = factor; } // on all rates, beside the schedule

    double givenRateFactor() const { return rateFactor_; }
    const OptimizeConfig& config() const { return config_; }
    const OptimizeState& state() const { return state_; }
    const Scene& scene() const { return scene_; }
    const std::vector<std::uint32_t>& parameters() const { return parameters_; }
    // Of the last step, regulariser included: entries() doubles per parameter. Empty before the first.
    const std::vector<std::vector<double>>& gradients() const { return gradients_; }

  private:
    StepReport wholeStep(); // begins with no gradients
    // `place` of `count`: where in the step the view stands.
    void addView(std::size_t view, std::size_t place, std::size_t count, StepReport& report);
    // What one image difference moves together: places in parameters_. Normals move along one of their axes (tangent_plane.h).
    struct CurvatureGroup {
        std::vector<std::size_t> parameters;
        std::size_t axis = 0;
    };
    std::vector<CurvatureGroup> curvatureGroups() const;
    void measureCurvature(std::span<const std::size_t> views, StepReport& report);
    // `answers`: of the views, to which is added how their pixels answer to the group.
    void measureGroup(const CurvatureGroup& moving, std::size_t groups, std::span<const std::size_t> views, std::vector<PixelAnswers>& answers,
                      StepReport& report);
    void restartCurvature();
    void forgetCurvature(std::size_t parameter);
    // Maps of one material that step together (coupled_maps.h).
    void findCoupled();
    const std::vector<std::size_t>* coupledWith(std::size_t parameter) const; // among them it; null: it steps alone
    std::size_t groupsOf(const std::vector<std::size_t>& maps) const;         // that curvatureGroups() has of them
    std::size_t placeInBlock(const std::vector<std::size_t>& maps, std::size_t parameter) const; // of its first channel
    std::size_t coarserBy(std::size_t parameter) const;                                        // texels along a side of one of the grid that it steps on
    std::size_t crossEntries(const std::vector<std::size_t>& maps) const;                      // of CrossCurvature
    // Adds to cross_ what a change of the group told in the derivatives by a map, `times` as much.
    void addCross(std::size_t parameter, const CurvatureGroup& moved, std::span<const double> derivatives, double times);
    void addCrossCurvature();
    std::uint64_t moveCoupled(std::size_t place, double rateFactor, double residual);
    bool measuresDiagonal(std::size_t parameter) const;
    bool measuresAnyDiagonal() const;
    bool seesTexels(std::size_t parameter) const; // whether its texels are told from what camera rays meet
    // Adds to seen_ what a view tells of the group. `a`, `b`: how its halves changed; `weight`: the curvature of its loss by the image; `noise`: ImageNoise::around.
    void addSeenTexels(const std::vector<std::size_t>& group, const FirstVertices& first, const Image& a, const Image& b, const Image& weight,
                       std::span<const float> noise);
    // By which a parameter moves where curvature is measured; refers to its values.
    CurvatureDirection curvatureDirection(std::size_t parameter) const;
    std::vector<float> movedValues(std::size_t parameter, std::size_t axis) const; // so moved
    void addDiagonal(std::size_t parameter);
    void setImageValues(std::size_t view);
    std::size_t carriedViews() const;
    void keepImages();
    void addLosses(StepReport& report);
    void findConstants(bool allowed);
    bool measuresConstants() const;
    void measureConstants(StepReport& report);
    void stepConstants(double rateFactor);
    std::size_t movedKinds() const; // of slots that step by a diagonal; those that curvatureGroups() moves together are one
    bool canScan(std::size_t parameter) const;
    // The place in parameters_ of the shape of a lobe that is tried after so many steps: one at a time.
    std::optional<std::size_t> scannedAfter(std::uint32_t steps) const;
    void scanShape(StepReport& report);
    void sumUp(StepReport& report);
    void guessUnseen(std::size_t parameter);
    std::vector<float> priorStrengths(std::size_t parameter) const; // as in addTotalVariation()
    void applyUpdate(StepReport& report);
    std::uint64_t move(std::size_t parameter, double rateFactor, double residual); // `residual`: the step's loss
    std::uint64_t moveByGaussNewton(std::size_t parameter, double rate, double lightUnit); // as updateByGaussNewton()
    const CoarseTexture* coarse(std::size_t parameter) const { return coarse_[parameter] ? &*coarse_[parameter] : nullptr; } // that it steps on; null: its own grid
    TextureGrid stepGrid(std::size_t parameter) const { return coarse_[parameter] ? coarse_[parameter]->coarse() : gridOf(scene_.parameters[parameters_[parameter]]); }
    float raisedFloorOf(std::uint32_t parameter) const; // that updates leave it at least; `parameter`: in the scene
    void raiseToFloors();
    void publish(StepReport& report);
    double rateFactor() const; // schedule included
    bool carriesImages() const { return cmpg::carriesImages(config_); }
    ViewOrder viewOrder() const;
    bool seesAll() const { return viewOrder().seesAll(state_.step); }
    RunningImage image(std::size_t view, const Target& target, std::uint32_t step);
    std::uint32_t imageSamples(std::size_t view, const Target& target) const;
    std::uint32_t perPixel(std::uint32_t samples) const; // of a configured number
    double changeSquared(std::size_t view) const;
    std::vector<std::uint32_t> countsOf(std::size_t view, std::uint32_t spp) const;
    OptimizerKind method(std::size_t parameter) const { return methods_[parameter]; }
    bool isConstant(std::size_t parameter) const { return std::find(constants_.begin(), constants_.end(), parameter) != constants_.end(); }
    bool usesDiagonal(std::size_t parameter) const { return method(parameter) == OptimizerKind::GaussNewton && !isConstant(parameter); }
    bool isNormal(std::size_t parameter) const { return scene_.parameters[parameters_[parameter]].kind == SlotKind::Normal; }
    bool anyUsesDiagonal() const;
    // Of all entries of constants_, in their order.
    template <class Value> std::vector<double> ofConstants(const Value& value) const;
    std::vector<float> constantValues() const;
    std::vector<double> constantUnits() const;
    std::vector<double> constantRanges() const;
    bool weighsByNoise() const;
    bool newton() const { return std::find(methods_.begin(), methods_.end(), OptimizerKind::GaussNewton) != methods_.end(); }

    ImageModel& model_;
    Scene& scene_;
    OptimizeConfig config_;
    std::vector<std::uint32_t> parameters_;
    std::vector<OptimizerKind> methods_; // of the parameters
    std::vector<std::optional<CoarseTexture>> coarse_; // of the parameters: the grid that stands for one; none: its own
    std::vector<std::size_t> constants_; // places in parameters_ of those that step together
    std::vector<std::vector<std::size_t>> coupled_; // of maps
    OptimizeState state_;
    double rateFactor_ = 1;
    std::vector<double> tolerance_; // of each view's loss, beside the prior
    double viewShare_ = 1;          // of the views that the step sees, of all
    std::vector<double> information_;             // of the step's images for a parameter, as if it saw all: the sum over the views of values / expected loss
    std::vector<std::vector<double>> gradients_;
    std::vector<std::vector<double>> noise_;      // of the step's derivative passes, where they come in halves: half of how these differ
    std::vector<TotalVariationBound> known_;      // of the step
    std::vector<std::vector<double>> curvature_;  // what the step has measured of it; empty where it has not
    std::vector<CrossCurvature> cross_;           // of coupled_, the same
    std::vector<SeenTexels> seen_;                // of the parameters, what the same passes tell of texels that cameras see
    std::vector<std::vector<double>> peak_;       // the largest of its views alone, where a step does not see all
    std::vector<std::vector<float>> shares_;      // OptimizeState::pixelShares from this step on
    ConstantCurvature constantCurvature_;         // OptimizeState::constants from this step on
    std::vector<std::pair<std::size_t, RunningImage>> images_; // of the step in flight: views and their images
    std::vector<ViewLoss> losses_;                             // OptimizeState::losses from this step on
    SharedValues second_;                                      // the model's second values
};

} // namespace cmpg
