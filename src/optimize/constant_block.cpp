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
constexpr double kOldAfter = 0.15;    // of the unit or the value, whichever is larger
constexpr double kShareWeight = 0.3;  // of the latest step in the averages of signal and noise
constexpr int kSweeps = 10000;        // of coordinate descent: for matrices of a condition of 1000
constexpr double kSettled = 1e-6;     // of the bounds

struct ByChannel {
    std::array<double, 3> channel{};
    ByChannel& operator+=(const ByChannel& other) {
        for (std::size_t c = 0; c < 3; ++c)
            channel[c] += other.channel[c];
        return *this;
    }
};

ByChannel product(const Image& a, const Image& b, const Image& weight) {
    return orderedSum<ByChannel>(a.pixels(), kPixelsAtATime, [&](std::size_t begin, std::size_t end) {
        ByChannel sum;
        for (std::size_t p = begin; p < end; ++p)
            for (std::size_t c = 0; c < 3; ++c) {
                const double term = double(weight.values[3 * p + c]) * a.values[3 * p + c] * b.values[3 * p + c];
                sum.channel[c] += std::isfinite(term) ? term : 0;
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

void addProducts(std::span<const ConstantColumn> columns, const Image& weight, std::span<double> products) {
    std::size_t count = 0;
    std::vector<std::size_t> first;
    for (const ConstantColumn& column : columns) {
        first.push_back(count);
        count += column.entries;
    }
    for (std::size_t i = 0; i < columns.size(); ++i)
        for (std::size_t j = 0; j < columns.size(); ++j) {
            const ByChannel sums = product(columns[i].half[0], columns[j].half[1], weight);
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t row = first[i] + (columns[i].entries == 1 ? 0 : c), column = first[j] + (columns[j].entries == 1 ? 0 : c);
                products[row * count + column] += sums.channel[c] / (columns[i].step * columns[j].step);
            }
        }
}

void ConstantCurvature::add(std::span<const double> products, std::span<const float> values, std::span<const double> unit) {
    const std::size_t count = values.size();
    const bool first = empty() || isOld(values, unit);
    matrix.resize(count * count);
    noise.resize(count * count);
    others.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t j = 0; j < count; ++j) {
            const double a = finiteOrZero(products[i * count + j]), b = finiteOrZero(products[j * count + i]), off = 0.5 * std::abs(a - b);
            double &mean = matrix[i * count + j], &error = noise[i * count + j];
            mean = first ? 0.5 * (a + b) : 0.5 * (mean + 0.5 * (a + b));
            error = first ? off : 0.5 * std::hypot(error, off);
        }
    at.assign(values.begin(), values.end());
}

void ConstantCurvature::addOthers(std::span<const double> product, std::span<const double> direction, std::span<const double> unit) {
    const std::size_t count = others.size();
    for (std::size_t i = 0; i < count; ++i)
        others[i] = std::abs(finiteOrZero(product[i]) - inner(std::span(matrix).subspan(i * count, count), direction)) / unit[i];
}

bool ConstantCurvature::isOld(std::span<const float> values, std::span<const double> unit) const {
    for (std::size_t i = 0; i < values.size(); ++i)
        if (std::abs(double(values[i]) - at[i]) > kOldAfter * std::max(unit[i], std::abs(double(at[i]))))
            return true;
    return false;
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
                                 std::span<const double> lowest, std::span<const double> highest, Moments& moments) {
    const std::size_t count = gradient.size();
    std::vector<double> matrix = curvature.matrix, g, h;
    const auto diagonal = [&](std::size_t i) { return curvature.matrix[i * count + i]; };
    for (std::size_t i = 0; i < count; ++i) {
        g.push_back(finiteOrZero(gradient[i]));
        h.push_back(finiteOrZero(half[i]));
        if (!(diagonal(i) > 0))
            continue;
        // Rows of errors, scaled by any positive numbers, add up to a diagonal that bounds them: by the roots of the diagonal, they are in one unit.
        double ridge = kLeastRidge * diagonal(i);
        for (std::size_t k = 0; k < count; ++k)
            if (diagonal(k) > 0)
                ridge += curvature.noise[i * count + k] * std::sqrt(diagonal(i) / diagonal(k));
        matrix[i * count + i] += ridge + curvature.others[i];
    }
    std::vector<double> step = boxMinimum(matrix, g, lowest, highest);
    const double weight = moments.steps++ == 0 ? 1 : kShareWeight;
    const double noise = -inner(h, boxMinimum(matrix, h, lowest, highest)), signal = -inner(g, step) - noise;
    SignalNoise& average = moments.noise[0];
    average.signal += weight * (signal - average.signal);
    average.noise += weight * (noise - average.noise);
    const double share = signalShare(average);
    for (double& s : step)
        s *= share;
    return step;
}

} // namespace cmpg
