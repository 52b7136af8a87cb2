// Optimisers over the entries of parameters. State is plain data on the host.
#pragma once

#include "optimize/regularizer.h"
#include "optimize/seen_texels.h"
#include "scene/scene.h"

#include <cmpg/options.h>

#include <array>
#include <memory>
#include <span>

namespace cmpg {

using SlotRates = std::array<float, kSlotKinds>; // indexed by SlotKind
constexpr SlotRates defaultRates() {
    SlotRates rates{};
    for (float& rate : rates)
        rate = -1;
    return rates;
}

struct OptimizerConfig {
    OptimizerKind kind = OptimizerKind::Adam;
    // Adam (Kingma and Ba 2015): the step of an entry is rate * m / (sqrt(v) + epsilon). Gradients of a mean over an image are of
    // the order of 1e-9 for a texel, and fall with the square of the light: 1e-17 where targets are 1e-4 as bright. So epsilon is far below the usual 1e-8.
    float beta1 = 0.9f, beta2 = 0.999f, epsilon = 1e-19f;
    // SGD: m = momentum * m + g; the step is rate * m * texels. Times the number of texels because the gradient by a texel shrinks
    // with its area: a rate then means the same at every resolution.
    float momentum = 0.9f;
    // Step per update of a parameter of each kind. Kinds without an upper bound (emission, radiance) step in units of the mean
    // of their starting values. Negative: the optimiser's default, below. Gauss-Newton (optimize/gauss_newton.h) knows how long its steps are; the rate bounds
    // them.
    SlotRates rates = defaultRates();
    Schedule schedule = Schedule::Constant;
    float finalFactor = 0.1f; // what the schedule has multiplied the rate by at the last step
};
#define SLOT(number, Name, name, channels, highest, adam, sgd) adam,
constexpr SlotRates kAdamRates = {
#include "shared/slots.def"
};
#define SLOT(number, Name, name, channels, highest, adam, sgd) sgd,
constexpr SlotRates kSgdRates = {
#include "shared/slots.def"
};

// Sets the rate of a slot, or of all where `slot` is empty. Error(Usage) where there is no such slot.
void setRate(SlotRates& rates, const std::string& slot, float rate);

// Step of a parameter of this kind: the configured one or the default.
float slotRate(const OptimizerConfig& config, SlotKind kind);

// Factor of the rate at `step` of `steps` (from 0): 1 at the first, finalFactor at the last.
double scheduleFactor(Schedule schedule, std::uint32_t step, std::uint32_t steps, float finalFactor);

// What a parameter of a kind is optimised with; never Auto. `newton`: Gauss-Newton has what it needs.
OptimizerKind methodOf(OptimizerKind asked, SlotKind kind, bool newton);

// What Gauss-Newton remembers of the noise of a gradient, of a texture or of coarser texels.
struct SignalNoise {
    std::vector<float> squares;   // by entry: average square of the gradient's noise; empty for constants, which step together
    double signal = 0, noise = 0; // averages of the gradient's squared length without noise, and of that of its noise
    // `whole`: squared length of a step's gradient, which has the signal's and the noise's in it; `stray`: that of the noise. `weight`: of the step.
    void follow(double whole, double stray, double weight) {
        signal += weight * (whole - stray - signal);
        noise += weight * (stray - noise);
    }
};

// What an optimiser remembers of one parameter.
struct Moments {
    float unit = 1;                   // what the rate is multiplied by: fixed from the starting values
    std::uint32_t start = 0;          // step of the run that they begin at
    std::vector<float> first, second; // second is empty for SGD; of Gauss-Newton: the last step, and the diagonal that bounds the curvature
    // Of Gauss-Newton alone:
    std::vector<float> peak; // as `second`, which is the mean over the views: the largest of one view; empty where steps see all views
    std::shared_ptr<const SeenTexels> seen; // the part of the curvature that is known texel by texel; null where none is
    std::shared_ptr<const ExpectedDifferences> expected; // of neighbours that no camera sees, from those that one does; null: they are alike
    std::uint32_t products = 0, steps = 0; // how often the curvature was measured, and steps since `start`
    std::vector<SignalNoise> noise{1};   // of the grid that the texture steps on, then of ever coarser ones
    // Whether `seen` and `noise` are of the grid, or of none yet.
    bool areOf(const TextureGrid& grid) const;
};
Moments initialMoments(const OptimizerConfig& config, const Parameter& parameter);

// Every value stays below this, also where its slot has no bound: light must leave room for sums of products.
constexpr float kLargestValue = 1e30f;

// One update of Adam or SGD of parameter.values, projected to the parameter's range; texels of normal maps are brought back to unit length. `step`
// counts from 0 (bias correction), `factor` is the schedule's. Entries whose gradient is not finite keep value and moments; returns
// how many.
std::uint64_t updateParameter(const OptimizerConfig& config, std::uint32_t step, double factor, std::span<const double> gradient,
                              Moments& moments, Parameter& parameter);

} // namespace cmpg
