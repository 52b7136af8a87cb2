// Methods of sampling and their constants; kinds are those of the library.
#pragma once

#include <cmpg/options.h>

namespace cmpg {

// Of directions, drawn from the guide where it knows something and the material is not too smooth; more compounds the weights of long paths.
constexpr float kGuideShare = 0.5f;

// A path whose expected contribution is this share of the average one goes on once. Below 1 there are more copies than deaths: what
// follows a split is cheaper than a path from the camera (measured on two scenes: 1.4 and 1.6 times the efficiency of 1).
constexpr float kRouletteEffort = 0.3f;

// How a pass draws directions.
struct SamplingMethod {
    Sampling kind = Sampling::Bsdf; // not Auto
    bool roulette = false;          // ends and splits paths by derivative-to-go
    bool operator==(const SamplingMethod&) const = default;
};

} // namespace cmpg
