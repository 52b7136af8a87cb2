// What the texels of a texture that no camera sees are expected to be.
#include "optimize/unseen_texels.h"

#include "optimize/texture_guess.h"

#include <algorithm>
#include <numeric>

namespace cmpg {

std::shared_ptr<const ExpectedDifferences> expectUnseen(const Parameter& parameter, const SeenTexels& seen) {
    constexpr double kTold = 0.1;                               // of the mean of what images tell of a texel, which is little of what only few rays meet
    constexpr std::size_t kMostExpected = std::size_t(1) << 20; // expected differences take 24 bytes each
    const std::size_t channels = parameter.channels, texels = parameter.entries() / channels;
    if (texels > kMostExpected || !seen.isWhole())
        return nullptr;
    const std::span<const float> curvature = seen.told();
    const double mean = std::accumulate(curvature.begin(), curvature.end(), 0.0) / double(texels);
    std::vector<bool> told(texels), met(texels);
    for (std::size_t t = 0; t < texels; ++t) {
        const double sum = std::accumulate(curvature.begin() + std::ptrdiff_t(t * channels), curvature.begin() + std::ptrdiff_t((t + 1) * channels), 0.0);
        told[t] = sum > kTold * mean;
        met[t] = sum > 0;
    }
    const TextureGrid grid = gridOf(parameter);
    std::optional<std::vector<float>> guess = guessTexture(grid, parameter.values, told);
    if (!guess)
        return nullptr;
    for (float& value : *guess)
        value = std::clamp(value, parameter.lowest(), parameter.highest());
    return std::make_shared<const ExpectedDifferences>(expectedDifferences(grid, *guess, met));
}

} // namespace cmpg
