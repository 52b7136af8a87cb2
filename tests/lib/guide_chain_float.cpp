// With exact masses in place of learned ones the conditional mixture has no variance: on a chain of a few points with four directions
// each, every path brings the same derivative. One channel, terms of one sign, no light sampling, no share of the material.
#include "shader_float.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;
using namespace gpu;

constexpr int kPoints = 6, kDepth = 5;

// Factors f of the four directions of each point, where they lead, emission E, and the derivatives of both. A point's R and dR depend
// on how many segments are left:
//     R(s, n) = sum_k f_k (E_k + R(k, n - 1)),    dR(s, n) = sum_k df_k (E_k + R(k, n - 1)) + f_k (dE_k + dR(k, n - 1))
struct Chain {
    double f[kPoints][4], df[kPoints][4], emission[kPoints], dEmission[kPoints];
    int next[kPoints][4];
    double light[kDepth + 1][kPoints] = {}, derivative[kDepth + 1][kPoints] = {};

    Chain(std::uint32_t seed, bool differentEmission) {
        std::mt19937 random(seed);
        const auto uniform = [&] { return double(random()) / 4294967296; };
        for (int s = 0; s < kPoints; ++s) {
            emission[s] = random() % 3 == 0 ? 5 * uniform() : 0;
            dEmission[s] = differentEmission && emission[s] > 0 ? uniform() : 0;
            for (int k = 0; k < 4; ++k) {
                f[s][k] = 0.6 * uniform();
                df[s][k] = s % 2 == 0 ? 3 * uniform() : 0; // half of the points know the parameter
                next[s][k] = int(random() % kPoints);
            }
        }
        emission[1] = 2;
        for (int n = 1; n <= kDepth; ++n)
            for (int s = 0; s < kPoints; ++s)
                for (int k = 0; k < 4; ++k) {
                    light[n][s] += lightMass(s, k, n);
                    derivative[n][s] += derivativeMass(s, k, n);
                }
    }
    double lightMass(int s, int k, int n) const { return f[s][k] * (emission[next[s][k]] + light[n - 1][next[s][k]]); }
    double derivativeMass(int s, int k, int n) const {
        const int t = next[s][k];
        return df[s][k] * (emission[t] + light[n - 1][t]) + f[s][k] * (dEmission[t] + derivative[n - 1][t]);
    }
};

// What many paths from point 0 bring: mean, and variance over the mean's square. `residue`: how far c R + b dR plus what was collected
// strays from its start on the way, relative.
struct Paths {
    double mean = 0, relativeVariance = 0, residue = 0;
};

Paths trace(const Chain& chain, std::uint32_t kind, bool segments) {
    constexpr int kPaths = 20000;
    std::mt19937 random(9);
    const auto uniform = [&] { return float(random() >> 8) / 16777216; };
    Library library;
    Paths result;
    double squares = 0;
    for (int path = 0; path < kPaths; ++path) {
        int s = 0;
        double b = 1, c = 0, collected = 0;
        for (int left = kDepth; left > 0 && (b > 0 || c > 0); --left) {
            shader_float::vec3 total(0), mass[4]; // quadrant k is direction k
            for (int k = 0; k < 4; ++k) {
                const int n = segments ? left : (kDepth + 1) / 2; // tables that do not know how many segments are left
                mass[k] = {float(chain.lightMass(s, k, n)), float(chain.derivativeMass(s, k, n)), 0};
                total += mass[k];
            }
            const shader_float::vec3 weights = library.guideWeights(kind, total, float(c), float(b), 0);
            const float score = dot(weights, total);
            if (!(score > library.kMinGuideScore)) break;
            // Drawn here, by the masses themselves: a quadtree rounds them to fractions.
            int k = 0;
            for (float at = uniform() * score; k < 3 && at >= dot(weights, mass[k]); ++k) at -= dot(weights, mass[k]);
            const double p = double(dot(weights, mass[k]) / score);
            if (!(p > 0)) break; // the last one by rounding
            c = (c * chain.f[s][k] + b * chain.df[s][k]) / p;
            b = b * chain.f[s][k] / p;
            s = chain.next[s][k];
            collected += c * chain.emission[s] + b * chain.dEmission[s];
            const double sum = c * chain.light[left - 1][s] + b * chain.derivative[left - 1][s] + collected;
            result.residue = std::max(result.residue, std::abs(sum / chain.derivative[kDepth][0] - 1));
        }
        result.mean += collected / kPaths;
        squares += collected * collected / kPaths;
    }
    result.relativeVariance = squares / (result.mean * result.mean) - 1;
    return result;
}

TEST(GuideChain, ConditionalMixtureHasNoVariance) {
    for (std::uint32_t seed = 0; seed < 8; ++seed)
        for (const bool differentEmission : {false, true}) {
            const Chain chain(seed, differentEmission);
            const double truth = chain.derivative[kDepth][0];
            const Paths exact = trace(chain, kGuideConditional, true);
            EXPECT_LT(exact.residue, 1e-5) << seed; // five steps of float masses
            EXPECT_NEAR(exact.mean, truth, 1e-5 * truth);
            EXPECT_LT(std::abs(exact.relativeVariance), 1e-5);
            // Others have some, with the same mean where their masses are nowhere 0 by mistake: 20 000 paths, four standard errors.
            const Paths light = trace(chain, kGuidePrimal, true), uniform = trace(chain, kGuideUniform, true);
            for (const Paths& p : {light, uniform}) {
                EXPECT_GT(p.relativeVariance, 1e-3) << seed;
                EXPECT_NEAR(p.mean, truth, 4 * truth * std::sqrt(p.relativeVariance / 20000)) << seed;
            }
            // Tables that do not know how many segments are left, as learned ones, leave a residue.
            EXPECT_GT(trace(chain, kGuideConditional, false).residue, 1e-2) << seed;
        }
}

} // namespace
} // namespace cmpg::test
