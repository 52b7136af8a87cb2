// Total variation of a texture.
#include "optimize/regularizer.h"

#include "optimize/ordered_sum.h"

#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kChunkRows = 16;

// For the pairs (from[i], to[i]): adds the smoothed |to - from| up, and leaves its derivatives by `to` in `derivative`.
double pairs(const float* from, const float* to, std::size_t count, double epsilon, double* derivative) {
    constexpr std::size_t kLane = 256; // values apart from their sum, so that the loop with the roots can be vectorised
    double value[kLane], sum = 0;
    for (std::size_t begin = 0; begin < count; begin += kLane) {
        const std::size_t n = std::min(kLane, count - begin);
        for (std::size_t i = 0; i < n; ++i) {
            const double d = double(to[begin + i]) - double(from[begin + i]);
            const double root = std::sqrt(d * d + epsilon * epsilon);
            value[i] = root - epsilon;
            derivative[begin + i] = d / root;
        }
        for (std::size_t i = 0; i < n; ++i)
            sum += value[i];
    }
    return sum;
}

} // namespace

double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, double epsilon) {
    const std::size_t height = parameter.height, channels = parameter.channels, row = parameter.width * channels;
    const bool environment = parameter.kind == SlotKind::Radiance;
    const bool wrapU = parameter.width > 1 && (environment || parameter.wrapU == Wrap::Repeat);
    const bool wrapV = height > 1 && !environment && parameter.wrapV == Wrap::Repeat;
    const double scale = weight / double(parameter.entries());

    // Every row gathers its own gradient, so that no two threads write to one entry. The value of a vertical pair is counted by the
    // upper row; its derivative is handed down, and formed again only where a range of rows begins.
    const double sum = orderedSum<double>(height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        const auto values = [&](std::size_t y) { return parameter.values.data() + (y % height) * row; };
        std::vector<double> across(row), above(row), below(row);
        if (begin > 0 || wrapV)
            pairs(values(begin + height - 1), values(begin), row, epsilon, above.data());
        double total = 0;
        for (std::size_t y = begin; y < end; ++y) {
            double* out = gradient.data() + y * row;
            total += pairs(values(y), values(y) + channels, row - channels, epsilon, across.data());
            if (wrapU)
                total += pairs(values(y) + row - channels, values(y), channels, epsilon, across.data() + row - channels);
            for (std::size_t i = 0; i < row; ++i)
                out[i] -= scale * across[i];
            for (std::size_t i = 0; i < channels; ++i)
                out[i] += scale * across[row - channels + i];
            for (std::size_t i = channels; i < row; ++i)
                out[i] += scale * across[i - channels];

            if (y + 1 < height || wrapV)
                total += pairs(values(y), values(y + 1), row, epsilon, below.data());
            else
                std::fill(below.begin(), below.end(), 0.0);
            for (std::size_t i = 0; i < row; ++i)
                out[i] += scale * (above[i] - below[i]);
            std::swap(above, below);
        }
        return total;
    });
    return scale * sum;
}

} // namespace cmpg
