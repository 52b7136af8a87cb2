// Textures and images of another size.
#include "scene/resample.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

struct Tap {
    std::size_t texel;
    float weight;
};

std::size_t wrapped(std::ptrdiff_t texel, std::ptrdiff_t size, Wrap wrap) {
    if (wrap == Wrap::Repeat)
        return std::size_t((texel + size) % size);
    return std::size_t(std::clamp<std::ptrdiff_t>(texel, 0, size - 1)); // a mirror repeats the texel at the edge, too
}

// Of which texels of an edge each of the new ones consists.
std::vector<std::vector<Tap>> tapsOf(std::uint32_t size, std::uint32_t newSize, Wrap wrap) {
    std::vector<std::vector<Tap>> taps(newSize);
    const double scale = double(size) / newSize;
    for (std::uint32_t i = 0; i < newSize; ++i) {
        if (scale <= 1) {
            const double at = (i + 0.5) * scale - 0.5, below = std::floor(at);
            const auto texel = std::ptrdiff_t(below);
            taps[i] = {{wrapped(texel, size, wrap), float(1 - (at - below))}, {wrapped(texel + 1, size, wrap), float(at - below)}};
            continue;
        }
        const double begin = i * scale, end = (i + 1) * scale;
        for (auto texel = std::uint32_t(begin); texel < size && texel < end; ++texel)
            taps[i].push_back({texel, float((std::min(end, texel + 1.0) - std::max(begin, double(texel))) / scale)});
    }
    return taps;
}

} // namespace

std::vector<float> resampled(std::span<const float> from, std::uint32_t channels, glm::uvec2 size, glm::uvec2 newSize, Wrap wrapU, Wrap wrapV) {
    if (size == newSize)
        return {from.begin(), from.end()};
    const auto across = tapsOf(size.x, newSize.x, wrapU), down = tapsOf(size.y, newSize.y, wrapV);
    std::vector<float> rows(std::size_t(size.y) * newSize.x * channels), result(std::size_t(newSize.y) * newSize.x * channels);
    for (std::size_t y = 0; y < size.y; ++y)
        for (std::size_t x = 0; x < newSize.x; ++x)
            for (const Tap& tap : across[x])
                for (std::size_t c = 0; c < channels; ++c)
                    rows[(y * newSize.x + x) * channels + c] += tap.weight * from[(y * size.x + tap.texel) * channels + c];
    const std::size_t row = std::size_t(newSize.x) * channels;
    for (std::size_t y = 0; y < newSize.y; ++y)
        for (const Tap& tap : down[y])
            for (std::size_t i = 0; i < row; ++i)
                result[y * row + i] += tap.weight * rows[tap.texel * row + i];
    return result;
}

} // namespace cmpg
