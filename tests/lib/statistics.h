// Significance of chi-square and normal statistics.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace cmpg::test {

inline double normalTail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); } // P(Z > z)

// P(X > chi2) by Wilson and Hilferty's cube root, good to a few percent of the tail from 10 degrees of freedom on.
inline double chiSquareTail(double chi2, double degrees) {
    const double v = 2 / (9 * degrees);
    return normalTail((std::cbrt(chi2 / degrees) - (1 - v)) / std::sqrt(v));
}

// Significance of observed counts against expected ones that add up to the same total. Cells expected to hold fewer than 10 are
// pooled in order until they do.
inline double chiSquareSignificance(const std::vector<double>& observed, const std::vector<double>& expected) {
    double chi2 = 0, o = 0, e = 0;
    int terms = 0;
    for (std::size_t i = 0; i < observed.size(); ++i) {
        o += observed[i];
        e += expected[i];
        if (e >= 10) {
            chi2 += (o - e) * (o - e) / e;
            ++terms;
            o = e = 0;
        }
    }
    if (e > 0 || o > 0) chi2 += (o - e) * (o - e) / std::max(e, double(1)); // the last, smaller pool; counts nowhere are seen too
    return chiSquareTail(chi2, std::max(terms, 1));
}

} // namespace cmpg::test
