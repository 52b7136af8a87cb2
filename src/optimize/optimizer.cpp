// Optimisers over the entries of parameters.
#include "optimize/optimizer.h"

#include "base/error.h"
#include "optimize/ordered_sum.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace cmpg {
namespace {

constexpr std::size_t kTexelsAtOnce = 1 << 15;

// First moments below this are set to 0: denormal floats are a hundred times slower, and entries that stop receiving gradients decay
// through them.
constexpr float kTiny = 1e-30f;

// A rate in the range of float, so that none times a moment of 0 is no number.
float finite(double rate) { return float(std::min(rate, double(std::numeric_limits<float>::max()))); }

// One entry's state in and out; the result is what is subtracted from its value.
struct AdamStep {
    float beta1, beta2, epsilon, rate, correction; // rate: with the first moment's bias correction; correction: of sqrt(v)

    float operator()(float g, float& m, float& v) const {
        m = beta1 * m + (1 - beta1) * g;
        m = std::abs(m) < kTiny ? 0.f : m;
        v = beta2 * v + (1 - beta2) * g * g;
        return rate * m / (std::sqrt(v) * correction + epsilon);
    }
};

struct SgdStep {
    float momentum, rate;

    float operator()(float g, float& m, float&) const {
        m = momentum * m + g;
        m = std::abs(m) < kTiny ? 0.f : m;
        return rate * m;
    }
};

void normalise(float* n) {
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length > 1e-6f) {
        for (int c = 0; c < 3; ++c)
            n[c] /= length;
    } else { // no direction left: the unperturbed normal
        n[0] = n[1] = 0;
        n[2] = 1;
    }
}

template <class Step>
std::uint64_t apply(const Step& step, std::span<const double> gradient, Moments& moments, Parameter& parameter) {
    const std::size_t channels = parameter.channels;
    const bool unit = parameter.kind == SlotKind::Normal && channels == 3;
    // A normal is a direction: a map of a scale above 1 has components beyond the range, and to clamp one alone would turn it.
    const float lowest = unit ? -kLongestNormal : parameter.lowest(), highest = unit ? kLongestNormal : std::min(parameter.highest(), kLargestValue);
    float* values = parameter.values.data();
    float* first = moments.first.data();
    float* second = moments.second.empty() ? moments.first.data() : moments.second.data(); // SGD reads it, to no effect
    return orderedSum<std::uint64_t>(parameter.entries() / channels, kTexelsAtOnce, [&](std::size_t begin, std::size_t end) {
        std::uint64_t skipped = 0;
        for (std::size_t i = begin * channels; i < end * channels; ++i) {
            const float g = float(gradient[i]);
            // Also refuses gradients whose square overflows: they would freeze the entry for good.
            const bool good = g * g <= std::numeric_limits<float>::max();
            float m = first[i], v = second[i];
            const float change = step(good ? g : 0.f, m, v);
            const float moved = std::clamp(values[i] - change, lowest, highest);
            values[i] = good && change == change ? moved : values[i]; // 0 / 0: nothing to follow
            second[i] = good ? v : second[i];
            first[i] = good ? m : first[i];
            skipped += !good;
        }
        if (unit)
            for (std::size_t texel = begin; texel < end; ++texel)
                normalise(values + 3 * texel);
        return skipped;
    });
}

} // namespace

void setRate(SlotRates& rates, const std::string& slot, float rate) {
    bool known = slot.empty();
    for (std::size_t kind = 0; kind < kSlotKinds; ++kind)
        if (slot.empty() || slot == slotName(SlotKind(kind))) {
            rates[kind] = rate;
            known = true;
        }
    if (!known)
        throw Error(ErrorKind::Usage, "there is no slot '" + slot + "'", {}, "slots are " + slotNames(), {"rate"});
}

float slotRate(const OptimizerConfig& config, SlotKind kind) {
    const float rate = config.rates[std::size_t(kind)];
    if (rate >= 0)
        return rate;
    return (config.kind == OptimizerKind::Sgd ? kSgdRates : kAdamRates)[std::size_t(kind)];
}

OptimizerKind methodOf(OptimizerKind asked, SlotKind kind, bool newton) {
    if (asked != OptimizerKind::Auto && asked != OptimizerKind::GaussNewton)
        return asked;
    // Where the channels of a texture mix, no diagonal bounds the curvature. Those of normals do not along the axes that they step by (tangent_plane.h).
    return (newton || asked == OptimizerKind::GaussNewton) && kind != SlotKind::SheenColor ? OptimizerKind::GaussNewton : OptimizerKind::Adam;
}

double scheduleFactor(Schedule schedule, std::uint32_t step, std::uint32_t steps, float finalFactor) {
    const double last = steps > 1 ? steps - 1 : 1;
    const double t = std::min(step / last, 1.0);
    switch (schedule) {
    case Schedule::Constant:
        return 1;
    case Schedule::Cosine:
        return finalFactor + (1.0 - finalFactor) * 0.5 * (1 + std::cos(std::numbers::pi * t));
    case Schedule::Exponential:
        return std::pow(double(finalFactor), t);
    }
    return 1;
}

bool Moments::areOf(const TextureGrid& grid) const {
    const std::vector<float>& squares = noise[0].squares;
    return (squares.empty() || squares.size() == grid.entries()) && (!seen || seen->fits(grid));
}

Moments initialMoments(const OptimizerConfig& config, const Parameter& parameter) {
    Moments moments;
    moments.first.assign(parameter.entries(), 0.f);
    if (config.kind != OptimizerKind::Sgd)
        moments.second.assign(parameter.entries(), 0.f);
    if (std::isinf(parameter.highest())) {
        const double sum = orderedSum<double>(parameter.entries(), kTexelsAtOnce, [&](std::size_t begin, std::size_t end) {
            double part = 0;
            for (std::size_t i = begin; i < end; ++i)
                part += parameter.values[i];
            return part;
        });
        const double mean = sum / double(parameter.entries());
        if (mean > 0 && std::isfinite(mean))
            moments.unit = float(mean);
    }
    return moments;
}

std::uint64_t updateParameter(const OptimizerConfig& config, std::uint32_t step, double factor, std::span<const double> gradient,
                              Moments& moments, Parameter& parameter) {
    const double rate = slotRate(config, parameter.kind) * factor * moments.unit;
    if (config.kind == OptimizerKind::Sgd) {
        const double texels = double(parameter.width) * parameter.height;
        return apply(SgdStep{config.momentum, finite(rate * texels)}, gradient, moments, parameter);
    }
    const double t = step + 1.0;
    const double first = 1 - std::pow(double(config.beta1), t), second = 1 - std::pow(double(config.beta2), t);
    return apply(AdamStep{config.beta1, config.beta2, config.epsilon, finite(rate / first), float(1 / std::sqrt(second))}, gradient, moments,
                 parameter);
}

} // namespace cmpg
