// What a scene gives: images, derivative images along a direction, gradients; of several passes with random numbers of their own.
#pragma once

#include "support/render_fixture.h"

namespace cmpg::test {

constexpr int kImageEdge = 16;

// What a scene is run with.
struct Setup {
    bool lightSampling = true;
    Sampler sampler = Sampler::Sobol;
    Sampling guided = Sampling::Bsdf; // else a guide learns from passes of its own first
    float guideShare = kGuideShare;
    bool roulette = false; // in reverse mode
};

// Where an entry of a transformed scene's parameter comes from: the direction there is `scale` times the direction here, and what comes
// back is added up. No index: all entries alike.
struct Source {
    std::uint32_t parameter = ~0u; // ~0: nowhere
    std::vector<std::uint32_t> index = {};
    float scale = 1;
};
using Sources = std::vector<Source>; // by parameter

Sources sameParameters(const Scene& scene);

using Directions = std::vector<std::vector<float>>; // by parameter; empty: not differentiated

struct Passes {
    std::uint32_t count = 4, spp = 4;
    std::uint64_t firstSeed = 1;
};

struct Outputs {
    std::vector<Image> image, forward;                   // by pass
    std::vector<std::vector<std::vector<double>>> reverse; // by pass, by parameter
    std::string trouble; // contributions that were dropped
};

// Parameters that are differentiated: all that are read, but no emission of what does not emit, which would make a lamp of it.
std::vector<bool> differentiated(const Scene& scene);

// Pixel weights of gradients.
Image adjointImage();

// `wanted`: parameters of the scene; directions for them. Gradients come by parameter of the scene, empty where not wanted.
Outputs run(const Scene& scene, const Setup& setup, const Directions& directions, const Passes& passes);

// The images alone, plain, by kernels of what the scene requires.
std::vector<Image> images(Scene scene, const Passes& passes);

// To a transformed scene and back.
Directions pushed(const Directions& directions, const Sources& sources, const Scene& there);
void pull(const std::vector<std::vector<double>>& there, const Sources& sources, double weight, std::vector<std::vector<double>>& here);

} // namespace cmpg::test
