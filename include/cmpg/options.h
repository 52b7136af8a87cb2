// Choices of how to draw, compare and step, with the names they have on the command line and in Python.
#pragma once

#include <cmpg/namespace.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace cmpg {

// How directions are drawn. All but Bsdf draw half of the directions from the guide, where it knows something and the material is not too
// smooth, the other half from the material. Light sampling joins all of them by multiple importance.
enum class Sampling {
    Bsdf,         // no guiding
    Primal,       // guided by light
    Differential, // guided by derivatives of light
    Uniform,      // by both, normalised, half and half
    Conditional,  // by both, weighted by what the path has collected so far
    Auto,         // the best of Bsdf, Primal and Conditional, by variance times cost
};

// Random numbers of the paths: independent ones, or Owen-scrambled Sobol points.
enum class Sampler { Independent, Sobol };

// Samples of a derivative pass in reverse mode: equally many in every pixel, or more where the adjoint is large.
enum class PixelSampling { Uniform, Adjoint };

// Of an image value x with target y, averaged over pixels and channels; eps = kLossEpsilon:
enum class Loss {
    Mse,         // (x - y)^2
    L1,          // |x - y|
    Smape,       // |x - y| / (|x| + |y| + eps)
    RelativeMse, // (x - y)^2 / (y^2 + eps)
};
constexpr double kLossEpsilon = 1e-2;

// Batches whose spread tells an error, and the most samples per pixel that an error target or a time budget may take where nothing is said.
constexpr std::uint32_t kFewestBatches = 8, kMostBatches = 64, kMostBudgeted = 1u << 16;

// Auto: Gauss-Newton, but Adam for textures of the sheen's colour;
// Adam alone where Gauss-Newton has not what it needs: a squared loss, and images that steps carry on. GaussNewton: the same, and an error there.
enum class OptimizerKind { Auto, GaussNewton, Adam, Sgd };
enum class Schedule { Constant, Cosine, Exponential };

// Names of the values of an enumeration.
template <class E> struct EnumName {
    E value;
    const char* name;
};
// The name of a value in such a table; empty where it has none.
template <class E, std::size_t N> constexpr const char* nameOf(E value, const EnumName<E> (&names)[N]) {
    for (const EnumName<E>& known : names)
        if (known.value == value)
            return known.name;
    return "";
}
inline constexpr EnumName<Sampling> kSamplings[] = {{Sampling::Bsdf, "bsdf"},       {Sampling::Primal, "primal"},
                                                    {Sampling::Differential, "differential"}, {Sampling::Uniform, "uniform"},
                                                    {Sampling::Conditional, "conditional"},   {Sampling::Auto, "auto"}};
inline constexpr EnumName<Sampler> kSamplers[] = {{Sampler::Sobol, "sobol"}, {Sampler::Independent, "independent"}};
inline constexpr EnumName<PixelSampling> kPixelSamplings[] = {{PixelSampling::Uniform, "uniform"}, {PixelSampling::Adjoint, "adjoint"}};
inline constexpr EnumName<Loss> kLosses[] = {
    {Loss::Mse, "mse"}, {Loss::L1, "l1"}, {Loss::Smape, "smape"}, {Loss::RelativeMse, "relative-mse"}};
inline constexpr EnumName<OptimizerKind> kOptimizers[] = {
    {OptimizerKind::Auto, "auto"}, {OptimizerKind::GaussNewton, "gauss-newton"}, {OptimizerKind::Adam, "adam"}, {OptimizerKind::Sgd, "sgd"}};
inline constexpr EnumName<Schedule> kSchedules[] = {
    {Schedule::Constant, "constant"}, {Schedule::Cosine, "cosine"}, {Schedule::Exponential, "exponential"}};

} // namespace cmpg

namespace cmpg::v1 {

// How a guide is learned and used, for experts.
struct GuideOptions {
    std::filesystem::path load = {};  // start from what saveGuide() wrote, of the same triangles; derivatives also of the same parameters
    bool keep = false;                // to be saved: learn one even where no pass would draw from it, and from a recovery's first step on
    float share = 0.5f;               // of directions, drawn from the guide where it knows something; the rest from the material; at most 0.95
    float rouletteEffort = 0.3f;      // a path whose expected contribution is this share of the average continues once; from 0.01 to 100
    std::uint32_t cellRecords = 6000; // records of a pass from which a cell splits; from 1 to 2^30
    double directionShare = 0.03;     // share of a cell's light or derivatives from which a quadrant of directions splits; from 1e-4 to 1
    double forgetting = 0.9;          // what is kept of what was learned before parameters changed, each time; from 0 to 1
};

// How paths are drawn, and what they may take: fixed for the life of a renderer or a recovery. Defaults are those of the command line.
struct PathOptions {
    std::uint32_t maxDepth = 0; // segments of a path, 1: lights seen directly alone; 0: what the scene says, else 8; at most 1024
    Sampling sampling = Sampling::Auto;
    PixelSampling pixelSampling = PixelSampling::Adjoint;
    bool roulette = true;      // reverse mode: end and split paths by what the guide expects of them, where it pays
    bool positivize = false;   // derivative passes in two halves, one for each sign of the derivative
    bool lightSampling = true; // false: emitters are only found by chance
    std::uint64_t memory = 1024;    // MiB of device memory for a pass, beside the scene and its parameters; from 16
    std::uint64_t guideMemory = 64; // MiB of device memory for the guide, from 1 to 4096; cells stop splitting there
    Sampler sampler = Sampler::Sobol;
    GuideOptions guide = {};
    bool allFeatures = false; // kernels and buffers of all features, needed or not: the same results, slower; for comparison
};

} // namespace cmpg::v1
