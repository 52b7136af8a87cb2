// Weights of pixels by the noise of the image around them.
#include "optimize/noise_weights.h"

#include "base/parallel.h"
#include "optimize/losses.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cmpg {
namespace {

constexpr std::size_t kPixelsAround = 3; // neighbours to each side
constexpr std::size_t kRowsAtOnce = 16;

// Standard deviations, and the number of pixels that they are of.
struct Deviations {
    double sum = 0, count = 0;
    Deviations& operator+=(const Deviations& other) {
        sum += other.sum;
        count += other.count;
        return *this;
    }
};

// The sum over the places within kPixelsAround of place `i` of `count`, which are `stride` apart.
Deviations sumAround(const Deviations* from, std::size_t i, std::size_t count, std::size_t stride) {
    const std::size_t first = i - std::min(i, kPixelsAround), last = std::min(i + kPixelsAround, count - 1);
    Deviations sum;
    for (std::size_t k = first; k <= last; ++k)
        sum += from[k * stride];
    return sum;
}

} // namespace

ImageNoise noiseOf(Loss loss, const std::array<Image, 2>& halves, const Target& target) {
    const auto width = std::size_t(halves[0].width), height = std::size_t(halves[0].height);
    const std::size_t channels = std::size_t(halves[0].channels);
    std::vector<Deviations> own(width * height);
    parallelFor(own.size(), kRowsAtOnce * width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            if (!target.mask.empty() && target.mask[p] == 0) // the target may hold anything there
                continue;
            double square = 0;
            for (std::size_t k = p * channels; k < (p + 1) * channels; ++k) {
                const double y = target.image.values[k], half = 0.5 * (double(halves[0].values[k]) - double(halves[1].values[k]));
                square += lossTerm(loss, y + half, y).value; // in the unit of the loss
            }
            if (std::isfinite(square))
                own[p] = {std::sqrt(square / double(channels)), 1};
        }
    });
    double variance = 0, count = 0;
    for (const Deviations& pixel : own) {
        variance += pixel.sum * pixel.sum;
        count += pixel.count;
    }
    ImageNoise noise{std::vector<float>(own.size()), count > 0 ? variance / count : 0};
    std::vector<Deviations> across(own.size());
    parallelFor(height, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (std::size_t x = 0; x < width; ++x)
                across[y * width + x] = sumAround(own.data() + y * width, x, width, 1);
    });
    parallelFor(height, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y)
            for (std::size_t x = 0; x < width; ++x) {
                const std::size_t p = y * width + x;
                const Deviations around = sumAround(across.data() + x, y, height, width);
                const double neighbours = around.count - own[p].count;
                if (neighbours == 0)
                    continue;
                const double deviation = std::max(0.0, around.sum - own[p].sum) / neighbours;
                noise.around[p] = float(deviation * deviation);
            }
    });
    return noise;
}

std::vector<float> noiseWeights(Loss loss, const std::array<Image, 2>& halves, const Target& target, double value) {
    ImageNoise noise = noiseOf(loss, halves, target);
    const double scale = noise.mean + std::max(0.0, value);
    if (!(scale > 0) || !std::isfinite(scale))
        return {}; // an image without noise, or without anything to compare
    for (float& around : noise.around)
        around = float(scale / (scale + double(around)));
    return std::move(noise.around);
}

void weigh(Image& derivatives, std::span<const float> weights) {
    const std::size_t channels = std::size_t(derivatives.channels);
    for (std::size_t p = 0; p < weights.size(); ++p)
        for (std::size_t k = p * channels; k < (p + 1) * channels; ++k)
            derivatives.values[k] *= weights[p];
}

} // namespace cmpg
