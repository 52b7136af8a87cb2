// When two estimates of one thing agree.
//
// Differences of independent estimates with equal distributions are symmetric about 0. For independent symmetric differences d_i, however
// heavy their tails, |sum d_i| exceeds x sqrt(sum d_i^2) with a probability of at most 2 exp(-x^2 / 2): given the sizes only the signs
// are random (Hoeffding 1963; Efron 1969). So no standard error has to be known, and none can come out too small. The pixels of an image
// and passes with other seeds are independent. Estimates by other sampling methods have other distributions, whose differences need not be
// symmetric; their sums over many pixels nearly are.
#pragma once

#include "scene/image.h"

#include <cmath>
#include <string>
#include <vector>

namespace cmpg::test {

// That an equal pair is called different; of all comparisons of a run together.
constexpr double kFalseAlarms = 1e-3;

// x for this many comparisons.
inline double allowedScore(double comparisons) { return std::sqrt(2 * std::log(2 * comparisons / kFalseAlarms)); }

struct Comparison {
    std::string what;
    double difference = 0, squares = 0; // sums of d_i and d_i^2
    double size = 0;                    // sum of the estimates' absolute values
    double tolerance = 0;               // times the size: rounding, or a bound on what the relation neglects
    std::size_t terms = 0;

    void add(double a, double b) {
        difference += a - b;
        squares += (a - b) * (a - b);
        size += std::abs(a) + std::abs(b);
        ++terms;
    }
    // Never above sqrt(terms).
    double score() const {
        const double left = std::abs(difference) - tolerance * size;
        return left > 0 ? left / std::sqrt(squares) : 0;
    }
};

// Of equally long lists of images, pixel by pixel: each channel, and each quarter.
inline std::vector<Comparison> compareImages(const std::string& what, const std::vector<Image>& a, const std::vector<Image>& b, double tolerance) {
    std::vector<Comparison> all(7);
    for (std::size_t c = 0; c < 7; ++c) {
        all[c].what = what + (c < 3 ? ", channel " + std::to_string(c) : ", quarter " + std::to_string(c - 3));
        all[c].tolerance = tolerance;
    }
    for (std::size_t pass = 0; pass < a.size(); ++pass)
        for (int y = 0; y < a[pass].height; ++y)
            for (int x = 0; x < a[pass].width; ++x) {
                const float *p = a[pass].at(x, y), *q = b[pass].at(x, y);
                for (std::size_t c = 0; c < 3; ++c)
                    all[c].add(p[c], q[c]);
                all[3 + std::size_t(x >= a[pass].width / 2) + 2 * std::size_t(y >= a[pass].height / 2)].add(double(p[0]) + p[1] + p[2], double(q[0]) + q[1] + q[2]);
            }
    return all;
}

} // namespace cmpg::test
