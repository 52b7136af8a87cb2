// D + C + L of a texture, and steps by it.
#include "optimize/texture_curvature.h"

#include "optimize/conjugate_gradients.h"
#include "optimize/entry_loops.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

constexpr double kLeastCurvature = 1e-3;      // of the mean: entries that no path met in the passes that measured it
constexpr float kNoiseOfDifferences = 0.25f;  // of texels that a pixel sees at once: noise takes these no farther apart than `stray` over it

} // namespace

TextureCurvature::TextureCurvature(const TotalVariationBound& known, const SeenPart& seen, std::span<const float> measured, std::vector<float> deviation, float stray)
    : known_(known), seen_(seen), own_(std::move(deviation)), inverse_(measured.size()) {
    constexpr float kLeast = std::numeric_limits<float>::min(); // below, nothing depends on an entry
    const double mean = sumOfEntries(measured.size(), [&](std::size_t i) { return double(measured[i]); }) / double(std::max<std::size_t>(1, measured.size()));
    const auto least = float(kLeastCurvature * mean);
    forEachEntry(own_.size(), [&](std::size_t i) {
        const float noise = own_[i] / stray, seenRows = seen_.texels ? seen_.part * seen_.texels->rows()[i] : 0;
        own_[i] = std::max(std::max(measured[i] + least, noise) - seenRows, kNoiseOfDifferences * noise);
    });
    if (known_.empty())
        inverse_ = own_;
    else
        known_.diagonal(own_, inverse_);
    if (seen_.texels)
        forEachEntry(own_.size(), [&](std::size_t i) { inverse_[i] += seen_.part * seen_.texels->diagonal()[i]; });
    forEachEntry(own_.size(), [&](std::size_t i) { inverse_[i] = inverse_[i] >= kLeast ? 1 / inverse_[i] : 0.f; });
}

void TextureCurvature::multiply(std::span<const float> x, std::span<float> out) const {
    if (known_.empty())
        forEachEntry(own_.size(), [&](std::size_t i) { out[i] = own_[i] * x[i]; });
    else
        known_.multiply(own_, x, out);
    if (seen_.texels)
        seen_.texels->addMultiply(x, seen_.part, out);
}

double TextureCurvature::length(std::span<const float> gradient) const {
    return sumOfEntries(gradient.size(), [&](std::size_t i) { return double(gradient[i]) * gradient[i] * inverse_[i]; });
}

std::vector<float> TextureCurvature::solve(std::vector<float> gradient) const {
    const std::size_t count = gradient.size();
    std::vector<float> scaled(count);
    forEachEntry(count, [&](std::size_t i) { scaled[i] = inverse_[i] * gradient[i]; });
    if (known_.empty() && !seen_.texels)
        return scaled;
    return conjugateGradients(
        std::move(gradient), std::move(scaled), [&](std::span<const float> x, std::span<float> out) { multiply(x, out); },
        [&](float step, const std::vector<float>& direction, const std::vector<float>& image, std::vector<float>& x, std::vector<float>& residual, std::vector<float>& z) {
            return sumOfEntries(count, [&](std::size_t i) { // in one pass: large textures wait for memory
                x[i] += step * direction[i];
                residual[i] -= step * image[i];
                z[i] = inverse_[i] * residual[i];
                return double(residual[i]) * z[i];
            });
        });
}

} // namespace cmpg
