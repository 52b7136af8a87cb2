// Newton steps of constants: few entries, whose effects on an image may cancel each other, with the whole matrix of their curvature.
#include "optimize/constant_block.h"

#include "optimize/gauss_newton.h"
#include "optimize/ordered_sum.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kPixelsAtATime = 1 << 13;
constexpr double kLeastRidge = 1e-3;  // of the diagonal
constexpr double kShareWeight = 0.3;  // of the latest step in the averages of signal and noise
constexpr double kNoiseWeight = 0.3;  // and in that of a gradient's variance
constexpr int kSweeps = 10000;        // of coordinate descent: for matrices of a condition of 1000
constexpr double kSettled = 1e-6;     // of the bounds

// Sums over the pixels of two columns, by channel and of all channels.
struct ProductSums {
    std::array<double, 3> channel{}, square{};
    double squareOfAll = 0;
    ProductSums& operator+=(const ProductSums& other) {
        for (std::size_t c = 0; c < 3; ++c) {
            channel[c] += other.channel[c];
            square[c] += other.square[c];
        }
        squareOfAll += other.squareOfAll;
        return *this;
    }
};

// The product of each half of one column by the other half of the other is without bias. Products within the halves have that noise twice over: half their
// difference is 0 in expectation, and has the variance of the mean of both products where noise is normal.
ProductSums productSums(const ConstantColumn& i, const ConstantColumn& j, const Image& weight) {
    const float *ia = i.half[0].values.data(), *ib = i.half[1].values.data(), *ja = j.half[0].values.data(), *jb = j.half[1].values.data();
    return orderedSum<ProductSums>(weight.pixels(), kPixelsAtATime, [&](std::size_t begin, std::size_t end) {
        ProductSums sum;
        for (std::size_t p = begin; p < end; ++p) {
            double differenceOfAll = 0;
            for (std::size_t c = 0, k = 3 * p; c < 3; ++c, ++k) {
                const double half = 0.5 * double(weight.values[k]);
                const double product = half * (double(ia[k]) * jb[k] + double(ib[k]) * ja[k]), difference = half * (double(ia[k]) * ja[k] - double(ib[k]) * jb[k]);
                if (!std::isfinite(product) || !std::isfinite(difference))
                    continue;
                sum.channel[c] += product;
                sum.square[c] += difference * difference;
                differenceOfAll += difference;
            }
            sum.squareOfAll += differenceOfAll * differenceOfAll;
        }
        return sum;
    });
}

double finiteOrZero(double value) { return std::isfinite(value) ? value : 0; }

// M x + g of a coordinate.
double slope(std::span<const double> matrix, std::span<const double> gradient, std::span<const double> x, std::size_t row) {
    double sum = gradient[row];
    for (std::size_t k = 0; k < x.size(); ++k)
        sum += matrix[row * x.size() + k] * x[k];
    return sum;
}

double inner(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
    return sum;
}

} // namespace

void addProducts(std::span<const ConstantColumn> columns, const Image& weight, ConstantProducts& products) {
    std::size_t count = 0;
    std::vector<std::size_t> first;
    for (const ConstantColumn& column : columns) {
        first.push_back(count);
        count += column.entries;
    }
    const auto add = [&](std::size_t row, std::size_t column, double mean, double variance) {
        products.mean[row * count + column] += mean;
        products.variance[row * count + column] += variance;
        if (row == column)
            return;
        products.mean[column * count + row] += mean;
        products.variance[column * count + row] += variance;
    };
    for (std::size_t i = 0; i < columns.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            const ProductSums sums = productSums(columns[i], columns[j], weight);
            const double steps = columns[i].step * columns[j].step;
            if (columns[i].entries == 1 && columns[j].entries == 1) {
                add(first[i], first[j], (sums.channel[0] + sums.channel[1] + sums.channel[2]) / steps, sums.squareOfAll / (steps * steps));
                continue;
            }
            for (std::size_t c = 0; c < 3; ++c)
                add(first[i] + (columns[i].entries == 1 ? 0 : c), first[j] + (columns[j].entries == 1 ? 0 : c), sums.channel[c] / steps,
                    sums.square[c] / (steps * steps));
        }
}

void ConstantCurvature::add(const ConstantProducts& products, std::span<const float> values, std::span<const double> range) {
    const std::size_t count = values.size();
    const bool first = empty() || isOld(values, range);
    matrix.resize(count * count);
    noise.resize(count * count);
    others.resize(count);
    for (std::size_t i = 0; i < count * count; ++i) {
        const double found = finiteOrZero(products.mean[i]), off = finiteOrZero(std::sqrt(products.variance[i]));
        matrix[i] = first ? found : 0.5 * (matrix[i] + found);
        noise[i] = first ? off : 0.5 * std::hypot(noise[i], off);
    }
    at.assign(values.begin(), values.end());
}

void ConstantCurvature::addOthers(std::span<const double> product, std::span<const double> direction, std::span<const double> unit) {
    const std::size_t count = others.size();
    for (std::size_t i = 0; i < count; ++i)
        others[i] += std::abs(finiteOrZero(product[i]) - inner(std::span(matrix).subspan(i * count, count), direction)) / unit[i];
}

bool ConstantCurvature::isOld(std::span<const float> values, std::span<const double> range) const {
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(double(values[i]) - at[i]) > range[i])
            return true;
    return false;
}

bool ConstantCurvature::isHidden(std::size_t entry) const {
    const std::size_t diagonal = entry * at.size() + entry;
    return noise[diagonal] > std::max(matrix[diagonal], 0.0);
}

bool ConstantCurvature::isNoisy() const {
    const std::size_t count = at.size();
    for (std::size_t i = 0; i < count; ++i)
        if (noise[i * count + i] > 0.5 * std::max(matrix[i * count + i], 0.0))
            return true;
    return false;
}

void CarriedGradient::advance(const ConstantCurvature& curvature, std::span<const float> values, std::span<const double> range,
                              std::span<const double> gradient, std::span<const double> half) {
    const std::size_t count = values.size();
    const bool first = mean.size() != count;
    mean.resize(count);
    variance.resize(count);
    squares.resize(count);
    double distance = 0; // in ranges
    if (!first)
        for (std::size_t i = 0; i < count; ++i)
            distance += std::abs(double(values[i]) - at[i]) / range[i];
    for (std::size_t i = 0; i < count; ++i) {
        const double now = finiteOrZero(gradient[i]), square = finiteOrZero(half[i] * half[i]);
        squares[i] += (first ? 1 : kNoiseWeight) * (square - squares[i]);
        if (first || !curvature.isHidden(i)) {
            mean[i] = now;
            variance[i] = square;
            continue;
        }
        const double unsure = std::min(distance, 1.0) * std::abs(mean[i]), before = variance[i] + unsure * unsure;
        const double sum = before + std::max(squares[i], square), weight = sum > 0 ? before / sum : 1;
        mean[i] += weight * (now - mean[i]);
        variance[i] = (1 - weight) * before;
    }
    at.assign(values.begin(), values.end());
}

std::vector<double> boxMinimum(std::span<const double> matrix, std::span<const double> gradient, std::span<const double> lowest,
                               std::span<const double> highest) {
    const std::size_t count = gradient.size();
    std::vector<double> x(count, 0.0);
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        double farthest = 0; // of the width of the bounds
        for (std::size_t i = 0; i < count; ++i) {
            const double diagonal = matrix[i * count + i], width = highest[i] - lowest[i];
            if (!(diagonal > 0) || !(width > 0))
                continue;
            const double next = std::clamp(x[i] - slope(matrix, gradient, x, i) / diagonal, lowest[i], highest[i]);
            farthest = std::max(farthest, std::abs(next - x[i]) / width);
            x[i] = next;
        }
        if (farthest < kSettled)
            break;
    }
    return x;
}

std::vector<double> constantStep(const ConstantCurvature& curvature, std::span<const double> gradient, std::span<const double> half,
                                 std::span<const double> lowest, std::span<const double> highest, std::span<const double> rate, Moments& moments) {
    const std::size_t count = gradient.size();
    std::vector<double> matrix = curvature.matrix, g, h;
    // What the diagonal may be: noise alone where it has made it negative, so that a step is short, and not none.
    const auto diagonal = [&](std::size_t i) { return std::max(curvature.matrix[i * count + i], 0.0) + curvature.noise[i * count + i]; };
    for (std::size_t i = 0; i < count; ++i) {
        g.push_back(finiteOrZero(gradient[i]));
        h.push_back(finiteOrZero(half[i]));
        if (!(diagonal(i) > 0))
            continue;
        // Rows of errors, scaled by any positive numbers, add up to a diagonal that bounds them: by the roots of the diagonal, they are in one unit.
        double ridge = kLeastRidge * diagonal(i);
        for (std::size_t k = 0; k < count; ++k)
            if (k != i && diagonal(k) > 0)
                ridge += curvature.noise[i * count + k] * std::sqrt(diagonal(i) / diagonal(k));
        matrix[i * count + i] = diagonal(i) + ridge + curvature.others[i];
    }
    std::vector<double> step = boxMinimum(matrix, g, lowest, highest);
    const double weight = moments.steps++ == 0 ? 1 : kShareWeight;
    const double noise = -inner(h, boxMinimum(matrix, h, lowest, highest)), signal = -inner(g, step) - noise;
    SignalNoise& average = moments.noise[0];
    average.signal += weight * (signal - average.signal);
    average.noise += weight * (noise - average.noise);
    const double share = signalShare(average);
    for (std::size_t i = 0; i < count; ++i) {
        step[i] *= share;
        const double known = std::max(curvature.matrix[i * count + i], 0.0), sure = 1 - h[i] * h[i] / (g[i] * g[i]);
        if (const double least = sure * std::min(rate[i], std::abs(g[i]) / known); curvature.isHidden(i) && std::abs(step[i]) < least)
            step[i] = std::clamp(g[i] > 0 ? -least : least, lowest[i], highest[i]);
    }
    return step;
}

} // namespace cmpg
