// Gauss-Newton steps: a diagonal that bounds the curvature of the loss, and the exact curvature of what is known of textures.
#include "optimize/gauss_newton.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {
namespace {

constexpr std::size_t kChunk = 1 << 15;
// Momentum of entries whose last step goes against this one's, and of others where the gradient is all signal: what images hardly tell, such as texels
// finer than a pixel, goes a small part of the distance in a step of a diagonal, always in one direction. Noise goes back and forth.
constexpr float kMomentum = 0.5f, kMostMomentum = 0.75f;
constexpr double kLeastCurvature = 1e-3; // of the mean: entries that no path met in the passes that measured it
constexpr double kNewWeight = 0.3;       // of the latest step in the averages of signal and noise
constexpr double kLeastShare = 0.02;     // of the signal: the average may be below 0 by chance
constexpr int kIterations = 30;          // of conjugate gradients: what is known spreads over so many texels in a step
constexpr double kTolerance = 1e-3;      // of the residual's norm

double dot(std::span<const float> a, std::span<const float> b) {
    return orderedSum<double>(a.size(), kChunk, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i)
            sum += double(a[i]) * b[i];
        return sum;
    });
}

double mean(std::span<const float> values) {
    return orderedSum<double>(values.size(), kChunk, [&](std::size_t begin, std::size_t end) {
               double sum = 0;
               for (std::size_t i = begin; i < end; ++i)
                   sum += values[i];
               return sum;
           }) / double(std::max<std::size_t>(1, values.size()));
}

template <class Entry> void forEach(std::size_t count, const Entry& entry) {
    parallelFor(count, kChunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            entry(i);
    });
}

// Finite, and its square as well.
bool isUsable(float value) { return value * value <= std::numeric_limits<float>::max(); }

float usableOrZero(double entry) { return isUsable(float(entry)) ? float(entry) : 0.f; }

// D + L, of which the diagonal stands apart, as its inverse.
struct Curvature {
    const TotalVariationBound& known;
    std::vector<float> own;     // D
    std::vector<float> inverse; // of D + the diagonal of L

    Curvature(const TotalVariationBound& bound, std::span<const float> measured, std::vector<float> noise, float stray)
        : known(bound), own(std::move(noise)), inverse(measured.size()) {
        constexpr float kLeast = std::numeric_limits<float>::min(); // below, nothing depends on an entry: it stays as it is
        const auto least = float(kLeastCurvature * mean(measured));
        forEach(own.size(), [&](std::size_t i) { own[i] = std::max(measured[i] + least, own[i] / stray); });
        if (known.empty())
            inverse = own;
        else
            known.diagonal(own, inverse);
        forEach(own.size(), [&](std::size_t i) { inverse[i] = inverse[i] >= kLeast ? 1 / inverse[i] : 0.f; });
    }

    // (D + L)^-1 g, by conjugate gradients with the diagonal as the preconditioner. `residual` is g.
    std::vector<float> solve(std::vector<float> residual) const {
        const std::size_t count = residual.size();
        std::vector<float> scaled(count);
        forEach(count, [&](std::size_t i) { scaled[i] = inverse[i] * residual[i]; });
        if (known.empty())
            return scaled;
        std::vector<float> x(count), direction = scaled, image(count);
        double length = dot(residual, scaled);
        const double enough = length * kTolerance * kTolerance;
        for (int k = 0; k < kIterations && length > enough; ++k) {
            known.multiply(own, direction, image);
            const double curvature = dot(direction, image);
            if (!(curvature > 0))
                break;
            const auto step = float(length / curvature);
            forEach(count, [&](std::size_t i) {
                x[i] += step * direction[i];
                residual[i] -= step * image[i];
                scaled[i] = inverse[i] * residual[i];
            });
            const double next = dot(residual, scaled);
            const auto turn = float(next / length);
            forEach(count, [&](std::size_t i) { direction[i] = scaled[i] + turn * direction[i]; });
            length = next;
        }
        return x;
    }
};

// Adds a gradient to the averages. The mean's length has the signal's and the noise's in it.
void observe(std::span<const float> gradient, std::span<const double> half, std::span<const float> unit, Moments& moments) {
    struct Lengths {
        double whole = 0, noise = 0;
        Lengths& operator+=(const Lengths& other) {
            whole += other.whole;
            noise += other.noise;
            return *this;
        }
    };
    const Lengths lengths = orderedSum<Lengths>(gradient.size(), kChunk, [&](std::size_t begin, std::size_t end) {
        Lengths sum;
        for (std::size_t i = begin; i < end; ++i) {
            const double n = usableOrZero(half[i]);
            sum.whole += double(gradient[i]) * gradient[i] * unit[i];
            sum.noise += n * n * unit[i];
        }
        return sum;
    });
    const double signal = lengths.whole - lengths.noise, weight = moments.steps++ == 0 ? 1 : kNewWeight;
    moments.signal += weight * (signal - moments.signal);
    moments.noise += weight * (lengths.noise - moments.noise);
}

} // namespace

double signalShare(const Moments& moments) {
    const double whole = moments.signal + moments.noise;
    return whole > 0 ? std::clamp(moments.signal / whole, kLeastShare, 1.0) : 1;
}

void addCurvature(std::span<const double> product, float direction, Moments& moments) {
    const bool first = moments.products++ == 0;
    forEach(product.size(), [&](std::size_t i) {
        const double found = product[i] / double(direction);
        const float bound = found > 0 && found < std::numeric_limits<float>::max() ? float(found) : 0.f; // noise, or a path that overflowed
        moments.second[i] = first ? bound : 0.5f * (moments.second[i] + bound);
    });
}

std::uint64_t updateByGaussNewton(double rate, NoisyGradient gradient, const TotalVariationBound& known, Moments& moments, Parameter& parameter) {
    const std::size_t count = parameter.entries();
    std::vector<float> g(count);
    const auto skipped = orderedSum<std::uint64_t>(count, kChunk, [&](std::size_t begin, std::size_t end) {
        std::uint64_t sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
            g[i] = usableOrZero(gradient.mean[i]);
            sum += !isUsable(float(gradient.mean[i]));
        }
        return sum;
    });
    std::vector<float> noise(count);
    forEach(count, [&](std::size_t i) {
        const float n = usableOrZero(gradient.half[i]), square = n * n;
        float& average = moments.third[i];
        average = moments.steps == 0 ? square : average + float(kNewWeight) * (square - average);
        noise[i] = std::sqrt(std::max(average, square));
    });
    const Curvature curvature(known, moments.second, std::move(noise), float(std::min(rate, 1e30)));
    observe(g, gradient.half, curvature.inverse, moments);
    gradient.half = std::vector<double>(); // before the solver takes memory
    const auto share = float(signalShare(moments));
    const std::vector<float> step = curvature.solve(std::move(g));
    const float reach = float(std::min(kNewtonReach * rate, 1e30)), lowest = parameter.lowest(), highest = std::min(parameter.highest(), kLargestValue);
    float* values = parameter.values.data();
    float* velocity = moments.first.data();
    const float along = kMomentum + (kMostMomentum - kMomentum) * share;
    forEach(count, [&](std::size_t i) {
        const float wanted = (velocity[i] * step[i] < 0 ? along : kMomentum) * velocity[i] - share * step[i];
        const float moved = std::clamp(values[i] + (wanted == wanted ? std::clamp(wanted, -reach, reach) : 0.f), lowest, highest);
        velocity[i] = moved - values[i];
        values[i] = moved;
    });
    return skipped;
}

} // namespace cmpg
