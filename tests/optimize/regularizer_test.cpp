// Total variation against a direct sum over pairs and finite differences.
#include "linear_model.h"
#include "optimize/regularizer.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

Parameter randomTexture(std::uint32_t width, std::uint32_t height, SlotKind kind = SlotKind::BaseColor) {
    Parameter parameter = test::makeParameter("m.baseColor", kind, width, height, 3, 0);
    std::mt19937 random(8);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float& value : parameter.values)
        value = uniform(random);
    return parameter;
}

// Sum over all ordered neighbour pairs, written as the definition reads.
double direct(const Parameter& parameter, double weight, bool wrapU, bool wrapV, const DifferenceCost& cost, const ExpectedDifferences& expected,
              const std::vector<float>& strengths) {
    double sum = 0;
    const auto valueOf = [&](double root) { return cost.unit == 0 ? root : std::pow(cost.unit, 0.25) * std::pow(root, 0.75); };
    const auto addPair = [&](std::uint32_t x, std::uint32_t y, std::uint32_t u, std::uint32_t v, const std::vector<float>& differences) {
        double squares = 0;
        for (std::uint32_t c = 0; c < parameter.channels; ++c) {
            const auto value = [&](std::uint32_t column, std::uint32_t line) {
                return double(parameter.values[(std::size_t(line) * parameter.width + column) * parameter.channels + c]);
            };
            const double difference =
                value(u, v) - value(x, y) - (differences.empty() ? 0 : double(differences[(std::size_t(y) * parameter.width + x) * parameter.channels + c]));
            squares += difference * difference;
        }
        const double mean = squares / parameter.channels;
        const auto strength = [&](std::uint32_t column, std::uint32_t line) { return strengths.empty() ? 1.f : strengths[std::size_t(line) * parameter.width + column]; };
        sum += double(std::min(strength(x, y), strength(u, v))) * parameter.channels * (valueOf(std::sqrt(mean + cost.epsilon * cost.epsilon)) - valueOf(cost.epsilon));
    };
    for (std::uint32_t y = 0; y < parameter.height; ++y)
        for (std::uint32_t x = 0; x < parameter.width; ++x) {
            if (x + 1 < parameter.width || wrapU)
                addPair(x, y, (x + 1) % parameter.width, y, expected.right);
            if (y + 1 < parameter.height || wrapV)
                addPair(x, y, x, (y + 1) % parameter.height, expected.below);
        }
    return weight * sum / double(parameter.entries());
}

const DifferenceCost kCosts[] = {kTotalVariation, {1e-3, 0.1}};

// Of a guess that has the entry's number in it, and of which every third texel is seen.
ExpectedDifferences someExpected(const Parameter& parameter) {
    std::vector<float> guess(parameter.entries());
    for (std::size_t i = 0; i < guess.size(); ++i)
        guess[i] = 0.5f + 0.4f * std::sin(float(i));
    std::vector<bool> seen(parameter.entries() / parameter.channels);
    for (std::size_t t = 0; t < seen.size(); t += 3)
        seen[t] = true;
    return expectedDifferences(gridOf(parameter), guess, seen);
}

std::vector<float> someStrengths(const Parameter& parameter) {
    std::vector<float> strengths;
    for (std::size_t t = 0; t < parameter.entries() / parameter.channels; ++t)
        strengths.push_back(0.6f + 0.4f * std::cos(float(t)));
    return strengths;
}

struct Case {
    Wrap u, v;
    SlotKind kind;
    bool wrapU, wrapV;
};
const Case kCases[] = {{Wrap::Repeat, Wrap::Repeat, SlotKind::BaseColor, true, true},
                       {Wrap::Repeat, Wrap::Clamp, SlotKind::BaseColor, true, false},
                       {Wrap::Mirror, Wrap::Repeat, SlotKind::BaseColor, false, true},
                       {Wrap::Clamp, Wrap::Mirror, SlotKind::BaseColor, false, false},
                       {Wrap::Clamp, Wrap::Repeat, SlotKind::Radiance, true, false}};

TEST(TotalVariation, ValueIsTheSumOverPairs) {
    for (const Case& c : kCases)
        for (const auto& [width, height] : {std::pair{37u, 41u}, {5u, 1u}, {1u, 5u}, {2u, 2u}, {1u, 1u}}) {
            Parameter parameter = randomTexture(width, height, c.kind);
            parameter.wrapU = c.u;
            parameter.wrapV = c.v;
            std::vector<double> gradient(parameter.entries());
            for (const DifferenceCost& cost : kCosts)
                for (const ExpectedDifferences& expected : {ExpectedDifferences(), someExpected(parameter)})
                    for (const std::vector<float>& strengths : {std::vector<float>(), someStrengths(parameter)})
                        EXPECT_NEAR(addTotalVariation(parameter, 0.7, gradient, cost, expected, strengths),
                                    direct(parameter, 0.7, c.wrapU, c.wrapV, cost, expected, strengths), 1e-12)
                            << width << " x " << height;
        }
}

// An edge costs least where all channels have theirs: as much as theirs alone where they are equally high.
TEST(TotalVariation, EdgesOfChannelsBelongTogether) {
    Parameter texture = test::makeParameter("m.baseColor", SlotKind::BaseColor, 4, 1, 3, 0.5f);
    texture.wrapU = Wrap::Clamp;
    std::vector<double> gradient(texture.entries());
    const auto cost = [&](std::initializer_list<std::size_t> edges) { // 0.3 up behind texel edges[c], in channel c
        std::fill(texture.values.begin(), texture.values.end(), 0.5f);
        std::size_t channel = 0;
        for (const std::size_t edge : edges) {
            for (std::size_t x = edge + 1; x < 4; ++x)
                texture.values[3 * x + channel] += 0.3f;
            ++channel;
        }
        return addTotalVariation(texture, double(texture.entries()), gradient);
    };
    EXPECT_NEAR(cost({1, 1, 1}), 3 * 0.3, 3.1e-3);
    EXPECT_NEAR(cost({0, 1, 2}), 3 * std::sqrt(3.0) * 0.3, 9.1e-3);
}

TEST(TotalVariation, GradientAgreesWithCentralDifferences) {
    for (const Case& c : kCases) {
        Parameter parameter = randomTexture(4, 37, c.kind); // tall enough for several ranges of rows
        parameter.wrapU = c.u;
        parameter.wrapV = c.v;
        for (std::size_t i = 0; i < 3; ++i)
            parameter.values[i] = parameter.values[3 + i] + 0.0005f; // one pair inside the smoothed part
        for (const DifferenceCost& cost : kCosts)
            for (const ExpectedDifferences& expected : {ExpectedDifferences(), someExpected(parameter)}) {
                const std::vector<float> strengths = expected.empty() ? std::vector<float>() : someStrengths(parameter);
                std::vector<double> gradient(parameter.entries(), 2.0), unused(parameter.entries());
                addTotalVariation(parameter, 0.7, gradient, cost, expected, strengths);
                for (std::size_t i = 0; i < parameter.entries(); ++i) {
                    const float value = parameter.values[i];
                    parameter.values[i] = value + 2e-5f;
                    const double up = parameter.values[i], above = addTotalVariation(parameter, 0.7, unused, cost, expected, strengths);
                    parameter.values[i] = value - 2e-5f;
                    const double down = parameter.values[i], below = addTotalVariation(parameter, 0.7, unused, cost, expected, strengths);
                    parameter.values[i] = value;
                    // Truncation h^2 f'''/6: f''' <= 0.86/eps^2 = 9e5 per pair, three pairs, times 0.7/444: 3e-7; rounding 1e-15 / h. The prior's slopes are 2.4 times
                    // as steep at 0, (unit / eps)^(1/4) 3/4.
                    EXPECT_NEAR(gradient[i] - 2.0, (above - below) / (up - down), cost.unit == 0 ? 4e-7 : 1e-6) << i;
                }
            }
    }
}

TEST(TotalVariation, IsZeroOnConstantsAndCountsTheSeamOnlyWhereTextureRepeats) {
    Parameter ramp = test::makeParameter("m.roughness", SlotKind::Roughness, 64, 1, 1, 0.3f);
    ramp.wrapU = Wrap::Repeat;
    std::vector<double> gradient(ramp.entries());
    EXPECT_EQ(addTotalVariation(ramp, 1, gradient), 0);
    for (std::uint32_t x = 0; x < 64; ++x)
        ramp.values[x] = float(x) / 63;
    const double repeated = addTotalVariation(ramp, 64, gradient);
    ramp.wrapU = Wrap::Clamp;
    EXPECT_NEAR(repeated - addTotalVariation(ramp, 64, gradient), 1, 2e-3); // the jump from 1 back to 0, less eps
}

} // namespace
} // namespace cmpg
