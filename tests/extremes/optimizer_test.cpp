// Optimisers driven far too fast, from the ends of the parameters' ranges, by gradients of all sizes.
#include "optimize/optimizer.h"
#include "worst.h"

#include <sstream>
#include <vector>

namespace cmpg::test {
namespace {

Parameter parameter(SlotKind kind, float value) {
    Parameter p;
    p.kind = kind;
    p.channels = kind == SlotKind::Roughness ? 1 : 3;
    p.width = 4;
    p.values.assign(p.entries(), value);
    if (kind == SlotKind::Normal)
        for (std::size_t i = 0; i < p.values.size(); ++i) p.values[i] = i % 3 == 2 ? 1.0f : 0.0f;
    return p;
}

// Values stay finite and in their range, and normals have length 1, whatever happens.
TEST(ExtremeOptimizers, StayInRange) {
    Worst outside("optimiser | values not finite or outside their range | rates 1e-30 to 1e38, gradients 0, 1e-40 to 1e38, infinite, not a number", "0", 0);
    const double gradients[] = {0, 1e-40, -1e-20, 1, -1e20, 1e30, -1e38, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()};
    for (const OptimizerKind optimizer : {OptimizerKind::Adam, OptimizerKind::Sgd})
        for (const SlotKind kind : {SlotKind::BaseColor, SlotKind::Roughness, SlotKind::Emission, SlotKind::Normal})
            for (const float start : {0.0f, 1e-40f, 1e-6f, 1.0f, 1e20f})
                for (const float rate : {1e-30f, 1.0f, 1e10f, 1e30f, 1e38f}) {
                    OptimizerConfig config;
                    config.kind = optimizer;
                    config.rates[std::size_t(kind)] = rate;
                    Parameter p = parameter(kind, std::min(start, parameter(kind, 0).highest()));
                    Moments moments = initialMoments(config, p);
                    for (std::uint32_t step = 0; step < 12; ++step) {
                        std::vector<double> g(p.entries());
                        for (std::size_t i = 0; i < g.size(); ++i) g[i] = gradients[(step * 7 + i * 3 + step / 3) % std::size(gradients)];
                        updateParameter(config, step, 1, g, moments, p);
                        for (std::size_t i = 0; i < p.values.size(); ++i) {
                            const float v = p.values[i];
                            const bool good = std::isfinite(v) && v >= p.lowest() && v <= p.highest();
                            outside.add(good ? 0 : 1, [&] {
                                std::ostringstream s;
                                s << "optimiser " << int(optimizer) << " slot " << slotName(kind) << " start " << start << " rate " << rate << " step " << step << " value " << v
                                  << " gradient " << g[i];
                                return s.str();
                            });
                        }
                        if (kind == SlotKind::Normal)
                            for (std::size_t i = 0; i < p.values.size(); i += 3)
                                outside.add(std::abs(std::hypot(p.values[i], p.values[i + 1], p.values[i + 2]) - 1) < 1e-5f ? 0 : 1, [] { return "a normal's length"; });
                    }
                }
}

// Adam's step does not depend on the gradient's scale, within what epsilon leaves of it.
TEST(ExtremeOptimizers, AdamFollowsGradientsOfAnySize) {
    Worst worst("optimiser | Adam's first step | gradients 1e-18 to 1e18, epsilon 0", "the rate", 1e-4);
    for (const double g : {1e-18, 1e-12, 1e-6, 1.0, 1e6, 1e12, 1e18}) {
        OptimizerConfig config;
        config.epsilon = 0;
        config.rates[std::size_t(SlotKind::BaseColor)] = 0.01f;
        Parameter p = parameter(SlotKind::BaseColor, 0.5f);
        Moments moments = initialMoments(config, p);
        updateParameter(config, 0, 1, std::vector<double>(p.entries(), g), moments, p);
        worst.compare(0.5 - double(p.values[0]), 0.01, [&] { return std::to_string(g); });
    }
}

} // namespace
} // namespace cmpg::test
