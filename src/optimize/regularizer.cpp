// Total variation of a texture.
#include "optimize/regularizer.h"

#include "optimize/ordered_sum.h"

#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kChunkRows = 16;

struct Pair {
    double value, derivative; // derivative by the difference
};

Pair smoothAbs(double d) {
    const double root = std::sqrt(d * d + kTotalVariationEpsilon * kTotalVariationEpsilon);
    return {d * d / (root + kTotalVariationEpsilon), d / root}; // = root - eps, without the cancellation
}

} // namespace

double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient) {
    const std::size_t height = parameter.height, channels = parameter.channels, row = parameter.width * channels;
    const bool environment = parameter.kind == SlotKind::Radiance;
    const bool wrapU = parameter.width > 1 && (environment || parameter.wrapU == Wrap::Repeat);
    const bool wrapV = height > 1 && !environment && parameter.wrapV == Wrap::Repeat;
    const double scale = weight / double(parameter.entries());

    // Every row gathers its own gradient, so that no two threads write to one entry; a vertical pair is formed twice and its value
    // counted by the upper row.
    const double sum = orderedSum<double>(height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        double total = 0;
        for (std::size_t y = begin; y < end; ++y) {
            const float* here = parameter.values.data() + y * row;
            double* out = gradient.data() + y * row;
            const auto horizontal = [&](std::size_t left, std::size_t right) {
                const Pair pair = smoothAbs(double(here[right]) - here[left]);
                total += pair.value;
                out[left] -= scale * pair.derivative;
                out[right] += scale * pair.derivative;
            };
            for (std::size_t i = channels; i < row; ++i)
                horizontal(i - channels, i);
            if (wrapU)
                for (std::size_t c = 0; c < channels; ++c)
                    horizontal(row - channels + c, c);

            if (y + 1 < height || wrapV) {
                const float* below = parameter.values.data() + (y + 1 < height ? y + 1 : 0) * row;
                for (std::size_t i = 0; i < row; ++i) {
                    const Pair pair = smoothAbs(double(below[i]) - here[i]);
                    total += pair.value;
                    out[i] -= scale * pair.derivative;
                }
            }
            if (y > 0 || wrapV) {
                const float* above = parameter.values.data() + (y > 0 ? y - 1 : height - 1) * row;
                for (std::size_t i = 0; i < row; ++i)
                    out[i] += scale * smoothAbs(double(here[i]) - above[i]).derivative;
            }
        }
        return total;
    });
    return scale * sum;
}

} // namespace cmpg
