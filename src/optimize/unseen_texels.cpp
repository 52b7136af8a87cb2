// What the texels of a texture that no camera sees are expected to be.
#include "optimize/unseen_texels.h"

#include "optimize/texture_guess.h"

#include <algorithm>
#include <numeric>

namespace cmpg {

namespace {

constexpr double kTold = 0.1;                               // of the mean of what images tell of a texel, which is little of what only few rays meet
constexpr std::size_t kMostExpected = std::size_t(1) << 20; // expected differences take 24 bytes each

// By texel, what images tell of all its channels.
std::vector<double> toldOf(const SeenTexels& seen, std::size_t channels) {
    const std::span<const float> entries = seen.told();
    std::vector<double> told(entries.size() / channels);
    for (std::size_t t = 0; t < told.size(); ++t)
        told[t] = std::accumulate(entries.begin() + std::ptrdiff_t(t * channels), entries.begin() + std::ptrdiff_t((t + 1) * channels), 0.0);
    return told;
}

std::vector<bool> above(const std::vector<double>& values, double least) {
    std::vector<bool> result;
    for (const double value : values)
        result.push_back(value > least);
    return result;
}

} // namespace

std::shared_ptr<const ExpectedDifferences> expectUnseen(const Parameter& parameter, const SeenTexels& seen, const CoarseTexture* coarse) {
    const std::size_t channels = parameter.channels;
    if (parameter.entries() / channels > kMostExpected || !seen.isWhole())
        return nullptr;
    const std::vector<double> told = toldOf(seen, channels);
    const double mean = std::accumulate(told.begin(), told.end(), 0.0) / double(told.size());
    const TextureGrid own = gridOf(parameter), &grid = coarse ? coarse->coarse() : own;
    std::optional<std::vector<float>> guess = guessTexture(grid, coarse ? coarse->meanOf(parameter.values) : parameter.values, above(told, kTold * mean));
    if (!guess)
        return nullptr;
    for (float& value : *guess)
        value = std::clamp(value, parameter.lowest(), parameter.highest());
    std::vector<bool> met = above(told, 0);
    if (coarse) {
        std::vector<float> fine(own.entries());
        coarse->spread(*guess, fine);
        guess = std::move(fine);
        met = coarse->nearest(met);
    }
    return std::make_shared<const ExpectedDifferences>(expectedDifferences(own, *guess, met));
}

} // namespace cmpg
