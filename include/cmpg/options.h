// Choices of how to draw, compare and step, with the names they have on the command line and in Python.
#pragma once

#include <cmpg/namespace.h>

#include <cstdint>

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

// Auto: Gauss-Newton for what an image depends on nearly linearly, and Adam for roughness and normals; Adam alone where Gauss-Newton has not
// what it needs: a squared loss, and images that steps carry on.
enum class OptimizerKind { Auto, GaussNewton, Adam, Sgd };
enum class Schedule { Constant, Cosine, Exponential };

// Names of the values of an enumeration.
template <class E> struct EnumName {
    E value;
    const char* name;
};
inline constexpr EnumName<Sampling> kSamplings[] = {{Sampling::Bsdf, "bsdf"},       {Sampling::Primal, "primal"},
                                                    {Sampling::Differential, "differential"}, {Sampling::Uniform, "uniform"},
                                                    {Sampling::Conditional, "conditional"},   {Sampling::Auto, "auto"}};
inline constexpr EnumName<PixelSampling> kPixelSamplings[] = {{PixelSampling::Uniform, "uniform"}, {PixelSampling::Adjoint, "adjoint"}};
inline constexpr EnumName<Loss> kLosses[] = {
    {Loss::Mse, "mse"}, {Loss::L1, "l1"}, {Loss::Smape, "smape"}, {Loss::RelativeMse, "relative-mse"}};
inline constexpr EnumName<OptimizerKind> kOptimizers[] = {
    {OptimizerKind::Auto, "auto"}, {OptimizerKind::GaussNewton, "gauss-newton"}, {OptimizerKind::Adam, "adam"}, {OptimizerKind::Sgd, "sgd"}};
inline constexpr EnumName<Schedule> kSchedules[] = {
    {Schedule::Constant, "constant"}, {Schedule::Cosine, "cosine"}, {Schedule::Exponential, "exponential"}};

} // namespace cmpg

namespace cmpg::v1 {

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
};

} // namespace cmpg::v1
