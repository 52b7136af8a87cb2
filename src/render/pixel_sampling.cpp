// Samples per pixel of a derivative pass, spent where the adjoint is large.
#include "render/pixel_sampling.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr double kFloor = 0.2;         // share of the samples spread evenly
constexpr double kMaximum = 1u << 24;  // samples of one pixel: counts stay exact in float
constexpr std::uint64_t kSalt = 0x7069786c73616d70ull; // keeps these numbers apart from everything keyed by the same pass

// Finaliser of splitmix64 (Steele, Lea, Flood 2014): every input bit reaches every output bit.
std::uint64_t mix(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

// Mean over the channels of |adjoint|.
double magnitude(const float* pixel, int channels) {
    double sum = 0;
    for (int c = 0; c < channels; ++c)
        sum += std::abs(double(pixel[c]));
    return std::isfinite(sum) ? sum / channels : 0;
}

} // namespace

PixelSamples sampleCounts(const Image& adjoint, std::uint32_t spp, const PassKey& key) {
    const std::size_t pixels = adjoint.pixels();
    double total = 0;
    for (std::size_t p = 0; p < pixels; ++p)
        total += magnitude(adjoint.values.data() + p * adjoint.channels, adjoint.channels);
    const double scale = total > 0 ? double(pixels) / total : 0;

    PixelSamples samples{std::vector<std::uint32_t>(pixels), std::vector<float>(pixels)};
    const std::uint64_t stream = mix(mix(key.seed ^ kSalt) + (std::uint64_t(key.step) << 32 | key.pass));
    for (std::size_t p = 0; p < pixels; ++p) {
        const double share = total > 0 ? magnitude(adjoint.values.data() + p * adjoint.channels, adjoint.channels) * scale : 1;
        const double expected = std::min(spp * (kFloor + (1 - kFloor) * share), kMaximum);
        const double whole = std::floor(expected);
        const double u = double(mix(stream + (p + 1) * 0x9e3779b97f4a7c15ull) >> 11) * 0x1p-53; // [0,1)
        samples.counts[p] = std::uint32_t(whole) + (u < expected - whole ? 1 : 0);
        samples.weights[p] = expected > 0 ? float(1 / expected) : 0.f;
    }
    return samples;
}

} // namespace cmpg
