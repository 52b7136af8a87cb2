// Forward gradients against finite differences of images, with what the comparison could have seen.
#include "optimize/gradient_check.h"

#include "base/student_t.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {
namespace {

// Probability of a false alarm of a whole check: that of 4 standard deviations of a normal variable, shared by all comparisons
// (Bonferroni).
constexpr double kFalseAlarm = 6.3e-5;
constexpr double kTruncation = 2e-3;     // relative; stencils of order 3 and 4 stay below it for |step * direction| <= kReach
constexpr double kRounding = 2.5e-7;     // of an image mean, in units of it: two ulps of a float
constexpr double kReach = 0.005;         // step * largest |direction|, of values in [0,1] or [-1,1]
constexpr double kReachUnbounded = 0.05; // same for unbounded values, in units of the largest; images are linear in them

struct StencilPoint {
    double offset, weight; // in units of the step; derivative = sum weight * f(offset) / step
};
using Stencil = std::vector<StencilPoint>;
const Stencil kCentral = {{-2, 1.0 / 12}, {-1, -8.0 / 12}, {1, 8.0 / 12}, {2, -1.0 / 12}};
const Stencil kUpward = {{0, -11.0 / 6}, {1, 3}, {2, -1.5}, {3, 1.0 / 3}};
const Stencil kDownward = {{0, 11.0 / 6}, {-1, -3}, {-2, 1.5}, {-3, -1.0 / 3}};

// A part of the direction whose entries can all move as far as the stencil needs.
struct Part {
    const Stencil* stencil;
    std::vector<float> direction;
    bool any = false;
};

double stepFor(const CheckSubject& s) {
    double largest = 0, magnitude = 0;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
        largest = std::max(largest, std::abs(double(s.direction[i])));
        magnitude = std::max(magnitude, std::abs(double(s.values[i])));
    }
    if (largest == 0)
        return 1;
    const bool bounded = std::isfinite(s.parameter->highest());
    return (bounded ? kReach : kReachUnbounded * (magnitude > 0 ? magnitude : 1)) / largest;
}

// Values at the edge of their range can only move inwards: their share of the direction gets a one-sided stencil.
std::vector<Part> splitByRange(const CheckSubject& s, double step) {
    std::vector<Part> parts{{&kCentral, {}}, {&kUpward, {}}, {&kDownward, {}}};
    const double lowest = s.parameter->lowest(), highest = s.parameter->highest();
    for (Part& part : parts)
        part.direction.assign(s.values.size(), 0);
    for (std::size_t i = 0; i < s.values.size(); ++i) {
        if (s.direction[i] == 0)
            continue;
        for (Part& part : parts) {
            bool inside = true;
            for (const StencilPoint& p : *part.stencil) {
                const double moved = s.values[i] + p.offset * step * s.direction[i];
                inside = inside && moved >= lowest && moved <= highest;
            }
            if (!inside && &part != &parts.back())
                continue;
            part.direction[i] = s.direction[i];
            part.any = true;
            break;
        }
    }
    std::erase_if(parts, [](const Part& part) { return !part.any; });
    return parts;
}

int blocksAlong(int pixels) {
    return std::min(pixels, kCheckBlocks);
}

// The mean of each channel, then of all channels over each block.
std::vector<double> summarise(const Image& image) {
    const int columns = blocksAlong(image.width), rows = blocksAlong(image.height);
    std::vector<double> sums(image.channels + std::size_t(columns) * rows), counts(sums.size());
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < image.channels; ++c) {
                const std::size_t block =
                    image.channels + std::size_t(y * rows / image.height) * columns + std::size_t(x * columns / image.width);
                for (std::size_t i : {std::size_t(c), block}) {
                    sums[i] += image.at(x, y)[c];
                    ++counts[i];
                }
            }
    for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] /= counts[i];
    return sums;
}

struct SampleMoments {
    std::vector<double> mean, varianceOfMean;
};

SampleMoments momentsOf(const std::vector<std::vector<double>>& samples) {
    const std::size_t n = samples.front().size();
    const double count = double(samples.size());
    SampleMoments m{std::vector<double>(n), std::vector<double>(n)};
    for (std::size_t i = 0; i < n; ++i) {
        for (const auto& s : samples)
            m.mean[i] += s[i] / count;
        for (const auto& s : samples)
            m.varianceOfMean[i] += (s[i] - m.mean[i]) * (s[i] - m.mean[i]) / (count * (count - 1));
    }
    return m;
}

double probabilityOf(const Comparison& c, double varianceA, double varianceB) {
    const double deviation = std::abs(c.forward - c.finite) - c.systematic;
    if (!std::isfinite(c.forward) || !std::isfinite(c.finite))
        return 0;
    if (deviation <= 0)
        return 1;
    if (c.standardError == 0)
        return 0;
    // Welch 1947: degrees of freedom of a difference of means with unequal variances.
    const double total = varianceA + varianceB;
    const double degrees = (kCheckRepetitions - 1) * total * total / (varianceA * varianceA + varianceB * varianceB);
    return studentTwoSided(deviation / c.standardError, degrees);
}

std::string nameOf(std::size_t index, int channels, int columns) {
    constexpr const char* kChannels[] = {"red mean", "green mean", "blue mean"};
    if (index < std::size_t(channels))
        return channels == 3 ? kChannels[index] : "mean";
    const std::size_t block = index - channels;
    return "block " + std::to_string(block % columns) + "," + std::to_string(block / columns);
}

} // namespace

CheckResult checkGradient(const CheckSubject& s) {
    CheckResult result;
    result.repetitions = kCheckRepetitions;
    result.step = stepFor(s);
    const std::vector<Part> parts = splitByRange(s, result.step);
    std::vector<std::vector<double>> forward, finite;
    std::vector<double> brightness; // mean magnitude of the renders, for the rounding bound
    int channels = 3, columns = 1;
    for (std::uint32_t r = 0; r < kCheckRepetitions; ++r) {
        const Image gradient = s.forward(r);
        channels = gradient.channels;
        columns = blocksAlong(gradient.width);
        forward.push_back(summarise(gradient));
        std::vector<double> difference(forward.back().size());
        for (const Part& part : parts)
            for (const StencilPoint& p : *part.stencil) {
                if (p.offset == 0)
                    continue; // weights add up to 0, so the image itself falls out
                std::vector<float> moved = s.values;
                for (std::size_t i = 0; i < moved.size(); ++i)
                    moved[i] = float(moved[i] + p.offset * result.step * part.direction[i]);
                const ImageDifference both = s.difference(r, moved);
                const std::vector<double> means = summarise(both.difference);
                for (std::size_t i = 0; i < means.size(); ++i)
                    difference[i] -= p.weight / result.step * means[i];
                brightness = summarise(both.image);
            }
        finite.push_back(std::move(difference));
    }
    const SampleMoments a = momentsOf(forward), b = momentsOf(finite);
    brightness.resize(a.mean.size());
    for (std::size_t i = 0; i < a.mean.size(); ++i) {
        Comparison c;
        c.what = nameOf(i, channels, columns);
        c.forward = a.mean[i];
        c.finite = b.mean[i];
        c.standardError = std::sqrt(a.varianceOfMean[i] + b.varianceOfMean[i]);
        c.systematic = kTruncation * std::abs(c.finite) + kRounding * std::abs(brightness[i]) / result.step;
        c.probability = probabilityOf(c, a.varianceOfMean[i], b.varianceOfMean[i]);
        result.comparisons.push_back(c);
    }
    result.threshold = kFalseAlarm / double(result.comparisons.size());
    return result;
}

} // namespace cmpg
