// Total variation of a texture.
#include "optimize/regularizer.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kChunkRows = 16;

// Of each of `count` texels the mean square over its channels of to - from.
void meanSquares(const float* from, const float* to, std::size_t count, std::size_t channels, double* out) {
    std::fill_n(out, count, 0.0);
    for (std::size_t c = 0; c < channels; ++c)
        for (std::size_t i = 0; i < count; ++i) {
            const double d = double(to[i * channels + c]) - double(from[i * channels + c]);
            out[i] += d * d;
        }
    for (std::size_t i = 0; i < count; ++i)
        out[i] /= double(channels);
}

// For the pairs of texels (from, to): adds up `channels` times the smoothed root mean square over the channels of to - from, and leaves its derivatives by
// `to` in `derivative`.
double pairs(const float* from, const float* to, std::size_t count, std::size_t channels, double epsilon, double* derivative) {
    constexpr std::size_t kLane = 256; // texels apart from their sum, so that the loop with the roots can be vectorised
    double root[kLane], sum = 0;
    for (std::size_t begin = 0; begin < count; begin += kLane) {
        const std::size_t n = std::min(kLane, count - begin), first = begin * channels;
        meanSquares(from + first, to + first, n, channels, root);
        for (std::size_t i = 0; i < n; ++i)
            root[i] = std::sqrt(root[i] + epsilon * epsilon);
        for (std::size_t c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t k = first + i * channels + c;
                derivative[k] = (double(to[k]) - double(from[k])) / root[i];
            }
        for (std::size_t i = 0; i < n; ++i)
            sum += root[i] - epsilon;
    }
    return double(channels) * sum;
}

struct Wraps {
    bool u, v;
};

Wraps wrapsOf(const Parameter& parameter) {
    const bool environment = parameter.kind == SlotKind::Radiance;
    return {parameter.width > 1 && (environment || parameter.wrapU == Wrap::Repeat),
            parameter.height > 1 && !environment && parameter.wrapV == Wrap::Repeat};
}

} // namespace

double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, double epsilon) {
    const std::size_t width = parameter.width, height = parameter.height, channels = parameter.channels, row = width * channels;
    const bool wrapU = wrapsOf(parameter).u, wrapV = wrapsOf(parameter).v;
    const double scale = weight / double(parameter.entries());

    // Every row gathers its own gradient, so that no two threads write to one entry. The value of a vertical pair is counted by the
    // upper row; its derivative is handed down, and formed again only where a range of rows begins.
    const double sum = orderedSum<double>(height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        const auto values = [&](std::size_t y) { return parameter.values.data() + (y % height) * row; };
        std::vector<double> across(row), above(row), below(row);
        if (begin > 0 || wrapV)
            pairs(values(begin + height - 1), values(begin), width, channels, epsilon, above.data());
        double total = 0;
        for (std::size_t y = begin; y < end; ++y) {
            double* out = gradient.data() + y * row;
            total += pairs(values(y), values(y) + channels, width - 1, channels, epsilon, across.data());
            if (wrapU)
                total += pairs(values(y) + row - channels, values(y), 1, channels, epsilon, across.data() + row - channels);
            for (std::size_t i = 0; i < row; ++i)
                out[i] -= scale * across[i];
            for (std::size_t i = 0; i < channels; ++i)
                out[i] += scale * across[row - channels + i];
            for (std::size_t i = channels; i < row; ++i)
                out[i] += scale * across[i - channels];

            if (y + 1 < height || wrapV)
                total += pairs(values(y), values(y + 1), width, channels, epsilon, below.data());
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

TotalVariationBound::TotalVariationBound(const Parameter& parameter)
    : width_(parameter.width), height_(parameter.height), channels_(parameter.channels), wrapU_(wrapsOf(parameter).u),
      wrapV_(wrapsOf(parameter).v) {}

void TotalVariationBound::add(const Parameter& parameter, double weight, double epsilon) {
    const std::size_t row = width_ * channels_;
    right_.resize(width_ * height_);
    below_.resize(width_ * height_);
    const double scale = weight / double(parameter.entries());
    const float* values = parameter.values.data();
    // Of the pairs of `count` texels from entry `from` and from entry `to` on.
    const auto add = [&](std::size_t from, std::size_t to, std::size_t count, std::vector<double>& square, float* weights) {
        meanSquares(values + from, values + to, count, channels_, square.data());
        for (std::size_t i = 0; i < count; ++i)
            weights[from / channels_ + i] += float(scale / std::sqrt(square[i] + epsilon * epsilon));
    };
    parallelFor(height_, kChunkRows, [&](std::size_t begin, std::size_t end) {
        std::vector<double> square(width_);
        for (std::size_t y = begin; y < end; ++y) {
            add(y * row, y * row + channels_, width_ - 1, square, right_.data());
            if (wrapU_)
                add(y * row + row - channels_, y * row, 1, square, right_.data());
            if (y + 1 < height_ || wrapV_)
                add(y * row, (y + 1) % height_ * row, width_, square, below_.data());
        }
    });
}

template <class Row> void TotalVariationBound::forRows(const Row& row) const {
    const std::size_t length = width_ * channels_;
    parallelFor(height_, kChunkRows, [&](std::size_t begin, std::size_t end) {
        std::vector<float> entries[4];
        // The weights of texels y * width_ + x for each of their channels, so that loops over entries can be vectorised.
        const auto spread = [&](const std::vector<float>& weights, std::size_t y, std::vector<float>& out) {
            out.resize(length);
            for (std::size_t x = 0; x < width_; ++x)
                std::fill_n(out.data() + x * channels_, channels_, weights[y * width_ + x]);
        };
        for (std::size_t y = begin; y < end; ++y) {
            auto& [right, left, below, above] = entries;
            // The last of a row, and the last row, have weight 0 where nothing wraps.
            spread(right_, y, right);
            left = right;
            std::rotate(left.begin(), left.end() - std::ptrdiff_t(channels_), left.end());
            spread(below_, y, below);
            spread(below_, (y + height_ - 1) % height_, above);
            row(y * length, Weights{right.data(), left.data(), below.data(), above.data()});
        }
    });
}

void TotalVariationBound::diagonal(std::span<const float> own, std::span<float> out) const {
    forRows([&](std::size_t begin, const Weights& w) {
        for (std::size_t i = 0; i < width_ * channels_; ++i)
            out[begin + i] = own[begin + i] + w.right[i] + w.left[i] + w.below[i] + w.above[i];
    });
}

void TotalVariationBound::multiply(std::span<const float> own, std::span<const float> x, std::span<float> out) const {
    const std::size_t length = width_ * channels_, last = length * (height_ - 1);
    forRows([&](std::size_t begin, const Weights& w) {
        const float* here = x.data() + begin;
        const float *under = x.data() + (begin < last ? begin + length : 0), *above = x.data() + (begin > 0 ? begin - length : last);
        float* to = out.data() + begin;
        const auto entry = [&](std::size_t i, std::size_t next, std::size_t before) {
            const float value = here[i];
            to[i] = own[begin + i] * value + w.right[i] * (value - here[next]) + w.left[i] * (value - here[before]) + w.below[i] * (value - under[i]) +
                    w.above[i] * (value - above[i]);
        };
        for (std::size_t i = 0; i < channels_; ++i)
            entry(i, (i + channels_) % length, length - channels_ + i);
        for (std::size_t i = channels_; i + channels_ < length; ++i)
            entry(i, i + channels_, i - channels_);
        for (std::size_t i = std::max(channels_, length - channels_); i < length; ++i)
            entry(i, i + channels_ - length, i - channels_);
    });
}

} // namespace cmpg
