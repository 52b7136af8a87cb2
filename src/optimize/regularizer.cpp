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
    right_.resize(row * height_);
    below_.resize(row * height_);
    const double scale = weight / double(parameter.entries());
    const float* values = parameter.values.data();
    // Of the pairs of `count` texels from entry `from` and from entry `to` on.
    const auto add = [&](std::size_t from, std::size_t to, std::size_t count, std::vector<double>& square, float* weights) {
        meanSquares(values + from, values + to, count, channels_, square.data());
        for (std::size_t i = 0; i < count * channels_; ++i)
            weights[from + i] += float(scale / std::sqrt(square[i / channels_] + epsilon * epsilon));
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

template <class Term> void TotalVariationBound::forPairs(std::size_t y, const Term& term) const {
    const std::size_t row = width_ * channels_, above = (y + height_ - 1) % height_, under = (y + 1) % height_;
    const float* r = right_.data() + y * row;
    for (std::size_t x = 0; x < row; ++x) {
        const std::size_t left = x >= channels_ ? x - channels_ : x + row - channels_, next = x + channels_ < row ? x + channels_ : x + channels_ - row;
        // The last of a row, and the last row, have weight 0 where nothing wraps.
        term(y * row + x, y * row + next, r[x]);
        term(y * row + x, y * row + left, r[left]);
        term(y * row + x, under * row + x, below_[y * row + x]);
        term(y * row + x, above * row + x, below_[above * row + x]);
    }
}

void TotalVariationBound::diagonal(std::span<const float> own, std::span<float> out) const {
    parallelFor(height_, kChunkRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            std::copy_n(own.data() + y * width_ * channels_, width_ * channels_, out.data() + y * width_ * channels_);
            forPairs(y, [&](std::size_t i, std::size_t, float weight) { out[i] += weight; });
        }
    });
}

void TotalVariationBound::multiply(std::span<const float> own, std::span<const float> x, std::span<float> out) const {
    parallelFor(height_, kChunkRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t y = begin; y < end; ++y) {
            for (std::size_t i = y * width_ * channels_; i < (y + 1) * width_ * channels_; ++i)
                out[i] = own[i] * x[i];
            forPairs(y, [&](std::size_t i, std::size_t other, float weight) { out[i] += weight * (x[i] - x[other]); });
        }
    });
}

} // namespace cmpg
