// How noisy the gradient of a step is.
#include "guiding/policy/gradient_noise.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr double kMostNoise = 100; // what is told of a gradient that is noise alone

} // namespace

void GradientNoise::add(const Gradients& half, const Gradients& sum) {
    noise_.resize(sum.size());
    signal_.resize(sum.size());
    for (std::size_t p = 0; p < sum.size(); ++p) {
        double noise = 0, signal = 0;
        for (std::size_t k = 0; k < sum[p].size(); ++k) {
            const double error = half[p][k], mean = sum[p][k];
            if (std::isfinite(error) && std::isfinite(mean)) {
                noise += error * error;
                signal += mean * mean;
            }
        }
        noise_[p] += noise;
        signal_[p] = signal; // of all views so far
    }
}

std::optional<double> GradientNoise::ratio() const {
    std::optional<double> most;
    for (std::size_t p = 0; p < noise_.size(); ++p)
        if (noise_[p] > 0)
            most = std::max(most.value_or(0), noise_[p] / std::max(signal_[p] - noise_[p], noise_[p] / kMostNoise));
    return most;
}

} // namespace cmpg
