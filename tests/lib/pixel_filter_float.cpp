// Reconstruction filters in the float build: where samples lie, against the filters' own formulas integrated in double precision.
#include "shader_float.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;

// Simpson's rule; splits at 0, where a tent has its corner.
double integral(const std::function<double(double)>& f, double a, double b) {
    if (a < 0 && b > 0)
        return integral(f, a, double(0)) + integral(f, double(0), b);
    constexpr int kSteps = 2000;
    const double h = (b - a) / kSteps;
    double sum = f(a) + f(b);
    for (int i = 1; i < kSteps; ++i)
        sum += f(a + i * h) * (i % 2 == 1 ? 4 : 2);
    return sum * h / 3;
}

struct Filter {
    const char* name;
    std::uint32_t kind;
    float radius, deviation;
    double operator()(double x) const {
        const double r = radius, s = deviation;
        if (kind == gpu::kFilterTent)
            return std::max(double(0), 1 - std::abs(x) / r);
        return std::max(double(0), std::exp(-x * x / (2 * s * s)) - std::exp(-r * r / (2 * s * s)));
    }
};

TEST(PixelFilter, SamplesLieInProportionToTheFilter) {
    Library library;
    for (const Filter& filter : {Filter{"tent", gpu::kFilterTent, 1, 0.5}, {"wide tent", gpu::kFilterTent, 2.5, 0.5}, {"gaussian", gpu::kFilterGaussian, 2, 0.5},
                                 {"wide gaussian", gpu::kFilterGaussian, 8, 2}})
        for (const auto& [low, high] : {std::pair{-filter.radius, filter.radius}, {-0.5f, filter.radius}, {-filter.radius, 0.5f}, {-0.5f, 0.5f}}) {
            const double whole = integral(filter, low, high);
            // The integral, at both ends: 1.5e-7 of the error function's formula and four roundings of 2^-24. And what the search leaves of the place, no more
            // than 22 halvings would, where filters are at most 1.
            const double scale = filter.kind == gpu::kFilterTent ? filter.radius : 1.2533 * filter.deviation;
            const double bound = (2 * (1.5e-7 + 2.4e-7) * scale + (high - low) / 4194304) / whole;
            float last = low;
            for (int i = 0; i <= 512; ++i) {
                const float u = std::min(float(i) / 512, std::nextafter(1.0f, 0.0f));
                const float x = library.filterOffset(filter.kind, filter.radius, filter.deviation, low, high, u);
                ASSERT_GE(x, last) << filter.name << ' ' << u << ": in order, so that even points stay even";
                ASSERT_LE(x, high) << filter.name << ' ' << u;
                ASSERT_NEAR(integral(filter, low, x) / whole, u, bound) << filter.name << ' ' << low << ' ' << high << ' ' << u;
                last = x;
            }
        }
}

} // namespace
} // namespace cmpg::test
