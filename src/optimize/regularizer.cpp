// Total variation of a texture.
#include "optimize/regularizer.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmpg {
namespace {

constexpr std::size_t kChunkRows = 16;

// A range of pairs: the first of the two texels, the second, and what the expected differences have for the first (null: 0). And, by texel, the strengths of
// both (null: 1).
struct Pairs {
    const float *from, *to, *expected, *strengthFrom, *strengthTo;

    // `first` and `second`: texels that the range begins with.
    Pairs(const Parameter& texture, std::size_t first, std::size_t second, const std::vector<float>& differences, std::span<const float> strengths)
        : from(texture.values.data() + first * texture.channels), to(texture.values.data() + second * texture.channels),
          expected(differences.empty() ? nullptr : differences.data() + first * texture.channels),
          strengthFrom(strengths.empty() ? nullptr : strengths.data() + first), strengthTo(strengths.empty() ? nullptr : strengths.data() + second) {}

    void skip(std::size_t texels, std::size_t channels) {
        from += texels * channels;
        to += texels * channels;
        expected += expected ? texels * channels : 0;
        strengthFrom += strengthFrom ? texels : 0;
        strengthTo += strengthTo ? texels : 0;
    }
    double difference(std::size_t i) const { return double(to[i]) - double(from[i]) - (expected ? double(expected[i]) : 0.0); }
    double strength(std::size_t texel) const { return strengthFrom ? double(std::min(strengthFrom[texel], strengthTo[texel])) : 1.0; }
};

// Of each of `count` pairs of texels the mean square over its channels of their differences.
void meanSquares(const Pairs& pairs, std::size_t count, std::size_t channels, double* out) {
    std::fill_n(out, count, 0.0);
    for (std::size_t c = 0; c < channels; ++c)
        for (std::size_t i = 0; i < count; ++i) {
            const double d = pairs.difference(i * channels + c);
            out[i] += d * d;
        }
    for (std::size_t i = 0; i < count; ++i)
        out[i] /= double(channels);
}

// (unit / r)^(1/4): how much less a difference costs.
double quarterRoot(double ratio) { return std::sqrt(std::sqrt(ratio)); }

double valueOf(const DifferenceCost& cost, double root) { return cost.unit == 0 ? root : root * quarterRoot(cost.unit / root); }
double slopeOf(const DifferenceCost& cost, double root) { return cost.unit == 0 ? 1 : 0.75 * quarterRoot(cost.unit / root); } // by root

// Adds up `channels` times what differences cost, and leaves its derivatives by the second texels in `derivative`.
double addPairs(Pairs pairs, std::size_t count, std::size_t channels, const DifferenceCost& cost, double* derivative) {
    constexpr std::size_t kLane = 256; // texels apart from their sum, so that the loop with the roots can be vectorised
    const double least = valueOf(cost, cost.epsilon);
    double root[kLane], slope[kLane], sum = 0;
    for (std::size_t begin = 0; begin < count; begin += kLane) {
        const std::size_t n = std::min(kLane, count - begin);
        meanSquares(pairs, n, channels, root);
        for (std::size_t i = 0; i < n; ++i)
            root[i] = std::sqrt(root[i] + cost.epsilon * cost.epsilon);
        for (std::size_t i = 0; i < n; ++i)
            slope[i] = pairs.strength(i) * slopeOf(cost, root[i]);
        for (std::size_t c = 0; c < channels; ++c)
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t k = i * channels + c;
                derivative[begin * channels + k] = pairs.difference(k) / root[i] * slope[i];
            }
        for (std::size_t i = 0; i < n; ++i)
            sum += pairs.strength(i) * (valueOf(cost, root[i]) - least);
        pairs.skip(n, channels);
    }
    return double(channels) * sum;
}

} // namespace

TextureGrid gridOf(const Parameter& parameter) {
    const bool environment = parameter.kind == SlotKind::Radiance;
    return {parameter.width, parameter.height, parameter.channels, parameter.width > 1 && (environment || parameter.wrapU == Wrap::Repeat),
            parameter.height > 1 && !environment && parameter.wrapV == Wrap::Repeat};
}

ExpectedDifferences expectedDifferences(const TextureGrid& grid, std::span<const float> guess, const std::vector<bool>& seen) {
    ExpectedDifferences expected{std::vector<float>(guess.size()), std::vector<float>(guess.size())};
    const auto between = [&](std::size_t from, std::size_t to, std::vector<float>& differences) { // texels
        if (!seen[from] || !seen[to])
            for (std::size_t c = 0; c < grid.channels; ++c)
                differences[from * grid.channels + c] = guess[to * grid.channels + c] - guess[from * grid.channels + c];
    };
    for (std::size_t y = 0; y < grid.height; ++y)
        for (std::size_t x = 0; x < grid.width; ++x) {
            between(y * grid.width + x, y * grid.width + (x + 1) % grid.width, expected.right);
            between(y * grid.width + x, (y + 1) % grid.height * grid.width + x, expected.below);
        }
    return expected;
}

double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, const DifferenceCost& cost, const ExpectedDifferences& expected,
                         std::span<const float> strengths) {
    const TextureGrid grid = gridOf(parameter);
    const std::size_t width = grid.width, height = grid.height, channels = grid.channels;
    const bool wrapU = grid.wrapU, wrapV = grid.wrapV; // by names of their own: not every compiler lets a lambda take those of a binding
    const std::size_t row = width * channels;
    const double scale = weight / double(parameter.entries());

    // Every row gathers its own gradient, so that no two threads write to one entry. The value of a vertical pair is counted by the
    // upper row; its derivative is handed down, and formed again only where a range of rows begins.
    const double sum = orderedSum<double>(height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        const auto rightOf = [&](std::size_t y) { return Pairs(parameter, y * width, y * width + 1, expected.right, strengths); };
        const auto under = [&](std::size_t y) { return Pairs(parameter, y * width, (y + 1) % height * width, expected.below, strengths); };
        std::vector<double> across(row), above(row), below(row);
        if (begin > 0 || wrapV)
            addPairs(under((begin + height - 1) % height), width, channels, cost, above.data());
        double total = 0;
        for (std::size_t y = begin; y < end; ++y) {
            double* out = gradient.data() + y * row;
            total += addPairs(rightOf(y), width - 1, channels, cost, across.data());
            if (wrapU) {
                const Pairs last(parameter, (y + 1) * width - 1, y * width, expected.right, strengths);
                total += addPairs(last, 1, channels, cost, across.data() + row - channels);
            }
            for (std::size_t i = 0; i < row; ++i)
                out[i] -= scale * across[i];
            for (std::size_t i = 0; i < channels; ++i)
                out[i] += scale * across[row - channels + i];
            for (std::size_t i = channels; i < row; ++i)
                out[i] += scale * across[i - channels];

            if (y + 1 < height || wrapV)
                total += addPairs(under(y), width, channels, cost, below.data());
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

TotalVariationBound::TotalVariationBound(const Parameter& parameter) : grid_(gridOf(parameter)) {}

void TotalVariationBound::add(const Parameter& parameter, double weight, const DifferenceCost& cost, const ExpectedDifferences& expected,
                              std::span<const float> strengths) {
    right_.resize(grid_.width * grid_.height);
    below_.resize(grid_.width * grid_.height);
    const double scale = weight / double(parameter.entries());
    // Of the pairs of `count` texels from `first` and from `second` on.
    const auto add = [&](std::size_t first, std::size_t second, const std::vector<float>& differences, std::size_t count, std::vector<double>& square, float* weights) {
        const Pairs pairs(parameter, first, second, differences, strengths);
        meanSquares(pairs, count, grid_.channels, square.data());
        for (std::size_t i = 0; i < count; ++i) {
            const double root = std::sqrt(square[i] + cost.epsilon * cost.epsilon);
            weights[first + i] += float(scale * pairs.strength(i) / root * slopeOf(cost, root));
        }
    };
    const std::size_t width = grid_.width;
    parallelFor(grid_.height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        std::vector<double> square(grid_.width);
        for (std::size_t y = begin; y < end; ++y) {
            add(y * width, y * width + 1, expected.right, width - 1, square, right_.data());
            if (grid_.wrapU)
                add((y + 1) * width - 1, y * width, expected.right, 1, square, right_.data());
            if (y + 1 < grid_.height || grid_.wrapV)
                add(y * width, (y + 1) % grid_.height * width, expected.below, width, square, below_.data());
        }
    });
}

namespace {

// Of fine texels along an axis: the coarse one that each centre lies in, and the coarse pair, by its first, that the edge after it lies in; the number of coarse
// ones where that is none. And the other way round.
struct Places {
    std::vector<std::size_t> texel, pair;
    std::vector<std::vector<std::size_t>> finesOfTexel, finesOfPair;

    Places(std::size_t fine, std::size_t coarse, bool wraps) : finesOfTexel(coarse), finesOfPair(coarse) {
        for (std::size_t i = 0; i < fine; ++i) {
            const auto at = std::ptrdiff_t(std::floor((double(i) + 1) * double(coarse) / double(fine) - 0.5)), count = std::ptrdiff_t(coarse);
            texel.push_back((2 * i + 1) * coarse / (2 * fine));
            pair.push_back(wraps ? std::size_t((at + count) % count) : at < 0 || at + 1 >= count ? coarse : std::size_t(at));
            finesOfTexel[texel.back()].push_back(i);
            if (pair.back() < coarse)
                finesOfPair[pair.back()].push_back(i);
        }
    }
};

} // namespace

TotalVariationBound TotalVariationBound::coarser(const CoarseTexture& texture) const {
    const TextureGrid& to = texture.coarse();
    TotalVariationBound result(to);
    if (empty())
        return result;
    result.right_.resize(to.width * to.height);
    result.below_.resize(to.width * to.height);
    const Places columns(grid_.width, to.width, to.wrapU), rows(grid_.height, to.height, to.wrapV);
    const auto square = [](double factor) { return float(factor * factor); };
    const float across = square(double(to.width) / double(grid_.width)), down = square(double(to.height) / double(grid_.height));
    // Of a coarse row, from the fine rows whose centres or edges lie in it.
    parallelFor(to.height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row) {
            float *right = result.right_.data() + row * to.width, *below = result.below_.data() + row * to.width;
            for (const std::size_t y : rows.finesOfTexel[row])
                for (std::size_t x = 0; x < grid_.width; ++x)
                    if (columns.pair[x] < to.width)
                        right[columns.pair[x]] += across * right_[y * grid_.width + x];
            for (const std::size_t y : rows.finesOfPair[row])
                for (std::size_t x = 0; x < grid_.width; ++x)
                    below[columns.texel[x]] += down * below_[y * grid_.width + x];
        }
    });
    return result;
}

template <class Row> void TotalVariationBound::forRows(const Row& row) const {
    const std::size_t length = grid_.width * grid_.channels;
    parallelFor(grid_.height, kChunkRows, [&](std::size_t begin, std::size_t end) {
        // The weights of texels y * grid_.width + x for each of their channels, so that loops over entries can be vectorised.
        const auto spread = [&](const std::vector<float>& weights, std::size_t y, float* out) {
            const float* from = weights.data() + y * grid_.width;
            if (grid_.channels == 3)
                for (std::size_t x = 0; x < grid_.width; ++x)
                    out[3 * x] = out[3 * x + 1] = out[3 * x + 2] = from[x];
            else
                for (std::size_t x = 0; x < grid_.width; ++x)
                    std::fill_n(out + x * grid_.channels, grid_.channels, from[x]);
        };
        // Those to the right have the last texel's before the first: from there on they are those to the left. The last of a row, and the last row, have weight 0
        // where nothing wraps.
        std::vector<float> across(grid_.channels + length), below(length), above(length);
        spread(below_, (begin + grid_.height - 1) % grid_.height, above.data());
        for (std::size_t y = begin; y < end; ++y) {
            float* right = across.data() + grid_.channels;
            spread(right_, y, right);
            std::copy_n(right + length - grid_.channels, grid_.channels, across.data());
            spread(below_, y, below.data());
            row(y * length, Weights{right, across.data(), below.data(), above.data()});
            std::swap(below, above);
        }
    });
}

void TotalVariationBound::diagonal(std::span<const float> own, std::span<float> out) const {
    forRows([&](std::size_t begin, const Weights& w) {
        for (std::size_t i = 0; i < grid_.width * grid_.channels; ++i)
            out[begin + i] = own[begin + i] + w.right[i] + w.left[i] + w.below[i] + w.above[i];
    });
}

void TotalVariationBound::multiply(std::span<const float> own, std::span<const float> x, std::span<float> out) const {
    const std::size_t length = grid_.width * grid_.channels, last = length * (grid_.height - 1);
    forRows([&](std::size_t begin, const Weights& w) {
        const float* here = x.data() + begin;
        const float *under = x.data() + (begin < last ? begin + length : 0), *above = x.data() + (begin > 0 ? begin - length : last);
        float* to = out.data() + begin;
        const auto entry = [&](std::size_t i, std::size_t next, std::size_t before) {
            const float value = here[i];
            to[i] = own[begin + i] * value + w.right[i] * (value - here[next]) + w.left[i] * (value - here[before]) + w.below[i] * (value - under[i]) +
                    w.above[i] * (value - above[i]);
        };
        for (std::size_t i = 0; i < grid_.channels; ++i)
            entry(i, (i + grid_.channels) % length, length - grid_.channels + i);
        for (std::size_t i = grid_.channels; i + grid_.channels < length; ++i)
            entry(i, i + grid_.channels, i - grid_.channels);
        for (std::size_t i = std::max(grid_.channels, length - grid_.channels); i < length; ++i)
            entry(i, i + grid_.channels - length, i - grid_.channels);
    });
}

} // namespace cmpg
