// When an optimisation looks for better methods of sampling than the plain one, and what it may spend on that.
#include "guiding/policy/exploration.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::uint32_t kFirst = 3;    // steps whose noise is told
constexpr std::uint32_t kWatch = 8;    // steps between two later ones
constexpr double kNoiseWeight = 0.3;   // of the latest step in the noise
constexpr double kPrecise = 0.25;      // noise below which nothing is tried
constexpr double kUrgent = 1;          // noise of the first steps above which everything is
constexpr double kTrialShare = 0.1;    // of all rays, for trials in between

} // namespace

bool Exploration::watches(std::uint32_t step) const { return step < kFirst || step % kWatch == 0; }

void Exploration::observeNoise(double noise) {
    if (!std::isfinite(noise))
        return;
    ++state_.watched;
    // The mean of the first ones.
    state_.noise += std::max(kNoiseWeight, 1.0 / state_.watched) * (noise - state_.noise);
    if (state_.watched <= kFirst && state_.noise > kUrgent)
        state_.urgent = true;
}

void Exploration::spend(double rays, double trials) {
    state_.spent += rays;
    state_.trials += trials;
}

bool Exploration::allows(std::uint32_t newKinds) const {
    if (state_.urgent)
        return true;
    return state_.noise > kPrecise && state_.trials + kKernelRays * newKinds < kTrialShare * state_.spent;
}

} // namespace cmpg
