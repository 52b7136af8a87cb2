// The image of an optimisation's view, carried from step to step.
#include "optimize/running_image.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kChunk = 1 << 15;
constexpr double kNewWeight = 0.2; // of the latest step in averages over steps, once there were as many as that stands for

struct Spread { // sums of products of how halves differ
    double first = 0, product = 0, second = 0;
    Spread& operator+=(const Spread& other) {
        first += other.first;
        product += other.product;
        second += other.second;
        return *this;
    }
};

// Mean over the entries of half the square of how two halves differ: the variance of one of them. And of two such pairs, their covariance.
Spread spread(const Image& a0, const Image& a1, const Image& b0, const Image& b1) {
    const std::size_t count = a0.values.size();
    const double unit = 0.5 / double(std::max<std::size_t>(1, count));
    Spread total = orderedSum<Spread>(count, kChunk, [&](std::size_t begin, std::size_t end) {
        Spread sum;
        for (std::size_t i = begin; i < end; ++i) {
            const double a = double(a0.values[i]) - a1.values[i], b = double(b0.values[i]) - b1.values[i];
            if (!std::isfinite(a) || !std::isfinite(b))
                continue;
            sum.first += a * a;
            sum.product += a * b;
            sum.second += b * b;
        }
        return sum;
    });
    return {total.first * unit, total.product * unit, total.second * unit};
}

double spread(const Image& a, const Image& b) { return spread(a, b, a, b).first; }

} // namespace

void RunningImage::begin(ImageHalves halves) {
    half = {std::move(halves.half[0].image), std::move(halves.half[1].image)};
    samples = halves.samples;
    imageVariance = spread(half[0], half[1]) * halves.samples;
    differenceVariance = covariance = 0;
    differences = 0;
}

void RunningImage::advance(const ImageHalves& halves) {
    const ImageDifference &a = halves.half[0], &b = halves.half[1];
    const double n = halves.samples;
    // The weight follows from earlier steps alone: one that sees this step's outliers would weigh them down and with them the mean.
    const double running = spread(half[0], half[1]) + differenceVariance / n, fresh = imageVariance / n, shared = covariance / n;
    const double denominator = running + fresh - 2 * shared;
    const float weight = denominator > 0 ? float(std::clamp((running - shared) / denominator, 0.0, 1.0)) : 0.5f;
    for (int h = 0; h < 2; ++h) {
        const ImageDifference& now = halves.half[h];
        for (std::size_t i = 0; i < half[h].values.size(); ++i) {
            const float carried = half[h].values[i] + now.difference.values[i];
            half[h].values[i] = carried + weight * (now.image.values[i] - carried);
        }
    }
    samples += halves.samples;
    const Spread found = spread(a.image, b.image, a.difference, b.difference);
    const double share = std::max(kNewWeight, 1.0 / (differences + 1.0));
    imageVariance += kNewWeight * (found.first * n - imageVariance);
    differenceVariance += share * (found.second * n - differenceVariance);
    covariance += share * (found.product * n - covariance);
    ++differences;
}

Image RunningImage::mean() const {
    Image image = half[0];
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = 0.5f * (image.values[i] + half[1].values[i]);
    return image;
}

double RunningImage::variance() const { return 0.5 * spread(half[0], half[1]); }

} // namespace cmpg
