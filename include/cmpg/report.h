// What a pass did: samples, errors, costs.
#pragma once

#include <cmpg/image.h>
#include <cmpg/options.h>

#include <map>
#include <string>
#include <vector>

namespace cmpg {

// Error of the mean of batches, relative to its own length: Euclidean norms over all entries (pixels or texels, channels).
struct EstimateError {
    double relative = 0;      // |standard error| / |mean|
    double low = 0, high = 0; // |mean - truth| / |mean| lies between them with 95 % confidence
    double degrees = 0;       // effective number of independent entries: 1 where all errors go together
};

// Why a pass with an error target or a time budget took no more samples.
enum class BudgetEnd { Samples, Error, Time };

// What learning passes measured of a method to draw directions.
struct MethodFigures {
    Sampling sampling = Sampling::Bsdf;
    bool roulette = false;    // ends and splits paths
    double variance = 0;      // of the result, for one sample per pixel and an adjoint of norm 1
    double raysPerPath = 0;
    std::uint32_t passes = 0; // that it was measured in
};

// What the guide did at one depth.
struct GuidedDepth {
    std::uint64_t drawn = 0, guided = 0, dead = 0; // directions drawn where it knew something; from it; of these, those that led nowhere
    double lightShare = 0;                         // sum over the drawn of the share of light (not of derivatives) in the mixture
};

// What the camera rays hit first, averaged over the samples of a pixel, and what the guide does at the vertices that follow.
struct Layers {
    Image normal = {}, depth = {}, albedo = {}, samples = {}; // 3, 1, 3, 1 channels; world-space normal, distance along the ray, count
    // 1 channel: share of directions drawn from the guide; that led nowhere; cell of the last sample.
    Image guided = {}, dead = {}, cell = {};
    // By depth, of the first few: share of light (not of derivatives) in the mixture, mean over the directions drawn there; -1 without any.
    std::vector<Image> lightShare = {};
};

} // namespace cmpg

namespace cmpg::v1 {

struct PassReport {
    int width = 0, height = 0;
    std::uint32_t spp = 0;     // samples per pixel of the result, of all batches
    std::uint32_t batches = 0; // 0: samples were not divided, and `error` says nothing
    EstimateError error = {};
    BudgetEnd end = BudgetEnd::Samples;

    // Wall: of the pass, and of the learning passes before it, without compilation. Of check(): of its derivatives, and of its images.
    double seconds = 0, learningSeconds = 0, imageSeconds = 0;
    // Those of learning passes included.
    std::uint64_t paths = 0, rays = 0;
    std::map<std::string, std::uint64_t> dropped = {}; // contributions left out, by kind: not finite, or too large to be summed
    std::uint64_t refusedSplits = 0;                   // of the guide's cells, for want of memory

    bool guided = false; // there is a guide
    std::uint32_t guideCells = 0, guideUpdates = 0; // its cells, and the passes or steps that it has learned from; 0: it knows nothing yet
    Sampling sampling = Sampling::Bsdf;
    bool roulette = false;
    std::vector<MethodFigures> figures = {};
    std::vector<GuidedDepth> depths = {}; // empty where nothing was guided

    Layers layers = {}; // where PassOptions::layers asks for them
};

} // namespace cmpg::v1
