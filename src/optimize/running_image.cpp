// The image of an optimisation's view, carried from step to step.
#include "optimize/running_image.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {
namespace {

constexpr std::size_t kChunk = 1 << 13; // pixels
constexpr double kNewWeight = 0.2;      // of the latest step in averages over steps, once there were as many as that stands for

struct Spread { // sums of products of how halves differ, over pixels and their channels
    double image = 0, product = 0, difference = 0;
    Spread& operator+=(const Spread& other) {
        image += other.image;
        product += other.product;
        difference += other.difference;
        return *this;
    }
};

// Of one sample each.
Spread spread(const ImageHalves& halves, std::span<const float> shares) {
    const ImageDifference &a = halves.half[0], &b = halves.half[1];
    return orderedSum<Spread>(a.image.pixels(), kChunk, [&](std::size_t begin, std::size_t end) {
        Spread sum;
        for (std::size_t p = begin; p < end; ++p) {
            const double weight = (shares.empty() ? 1.0 : double(shares[p]) * shares[p]) * halves.count(p);
            for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
                const double image = double(a.image.values[i]) - b.image.values[i], difference = double(a.difference.values[i]) - b.difference.values[i];
                if (!std::isfinite(image) || !std::isfinite(difference))
                    continue;
                sum.image += weight * image * image;
                sum.product += weight * image * difference;
                sum.difference += weight * difference * difference;
            }
        }
        return sum;
    });
}

} // namespace

void RunningImage::drop() {
    const std::uint32_t before = used;
    *this = {};
    used = before;
}

void RunningImage::count(const ImageHalves& halves, std::size_t pixels) {
    samples.resize(pixels, used);
    paths = 0;
    for (std::size_t p = 0; p < pixels; ++p) {
        samples[p] += halves.count(p);
        paths += 2 * std::uint64_t(halves.count(p));
        used = std::max(used, samples[p]);
    }
}

void RunningImage::begin(ImageHalves halves, Sampling drawnBy) {
    drop();
    method = drawnBy;
    const std::size_t pixels = halves.half[0].image.pixels();
    count(halves, pixels);
    for (std::size_t p = 0; p < pixels; ++p)
        worth.push_back(float(halves.count(p)));
    half = {std::move(halves.half[0].image), std::move(halves.half[1].image)};
}

void RunningImage::changeMethod(Sampling to, double ratio) {
    method = to;
    for (float& pixel : worth)
        pixel = std::max(float(pixel * ratio), std::numeric_limits<float>::min());
}

void RunningImage::advance(const ImageHalves& halves, std::span<const float> shares, double change) {
    // Weights follow from counts and earlier steps alone: ones that see this step's outliers would weigh them down and with them the mean.
    const double differing = differenceVariance * change, together = covariance * std::sqrt(change);
    const std::size_t pixels = half[0].pixels();
    for (std::size_t p = 0; p < pixels; ++p) {
        const double fresh = 1.0 / halves.count(p), running = 1.0 / worth[p] + differing * fresh, shared = together * fresh;
        const double denominator = running + fresh - 2 * shared;
        const double weight = denominator > 0 ? std::clamp((running - shared) / denominator, 0.0, 1.0) : 0.5, rest = 1 - weight;
        worth[p] = float(1 / std::max(1e-12, rest * rest * running + weight * weight * fresh + 2 * rest * weight * shared));
        for (int h = 0; h < 2; ++h) {
            const ImageDifference& now = halves.half[h];
            for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
                const float carried = half[h].values[i] + now.difference.values[i];
                half[h].values[i] = carried + float(weight) * (now.image.values[i] - carried);
            }
        }
    }
    count(halves, pixels);
    const Spread found = spread(halves, shares);
    if (!(change > 0) || !(found.image > 0))
        return;
    const double share = std::max(kNewWeight, 1.0 / (differences + 1.0));
    differenceVariance += share * (found.difference / found.image / change - differenceVariance);
    covariance += share * (found.product / found.image / std::sqrt(change) - covariance);
    ++differences;
}

Image RunningImage::mean() const {
    Image image = half[0];
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = 0.5f * (image.values[i] + half[1].values[i]);
    return image;
}

} // namespace cmpg
