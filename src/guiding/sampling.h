// How directions are drawn: the kinds a user can ask for.
#pragma once

namespace cmpg {

// All but Bsdf draw half of the directions from the guide, where it knows something and the material is not too smooth, the other
// half from the material. Light sampling joins all of them by multiple importance.
enum class Sampling {
    Bsdf,         // no guiding
    Primal,       // guided by light
    Differential, // guided by derivatives of light
    Uniform,      // by both, normalised, half and half
    Conditional,  // by both, weighted by what the path has collected so far
    Auto,         // the best of Bsdf, Primal and Conditional, by variance times cost
};

// Of directions, drawn from the guide where it knows something and the material is not too smooth; more compounds the weights of long paths.
constexpr float kGuideShare = 0.5f;

// A path whose expected contribution is this share of the average one goes on once. Below 1 there are more copies than deaths: what
// follows a split is cheaper than a path from the camera (measured on two scenes: 1.4 and 1.6 times the efficiency of 1).
constexpr float kRouletteEffort = 0.3f;

} // namespace cmpg
