// Student's t and the F distribution: how surprising a deviation is when its standard error was itself estimated from few samples.
#include "app/student_t.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// Continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), evaluated from its tail: the terms shrink so
// fast for x < (a+1)/(a+b+2) that a fixed depth gives full precision for the moderate a, b used here.
double betaFraction(double a, double b, double x) {
    double fraction = 1;
    for (int m = 200; m >= 1; --m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        fraction = 1 + even / (1 + odd / fraction);
    }
    return 1 / (1 - (a + b) * x / (a + 1) / fraction);
}

double incompleteBeta(double a, double b, double x) {
    if (x <= 0)
        return 0;
    if (x >= 1)
        return 1;
    const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x));
    return x < (a + 1) / (a + b + 2) ? front * betaFraction(a, b, x) / a : 1 - front * betaFraction(b, a, 1 - x) / b;
}

// Cube roots of mean squares are nearly normal (Wilson and Hilferty 1931): to 1e-4 of a probability from 100 degrees of freedom on.
constexpr double kManyDegrees = 200;

double nearlyNormal(double f, double above, double below) {
    const double a = 2 / (9 * above), b = 2 / (9 * below), root = std::cbrt(f);
    const double z = ((1 - b) * root - (1 - a)) / std::sqrt(b * root * root + a);
    return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

} // namespace

double studentTwoSided(double t, double degrees) {
    return std::isfinite(t) ? incompleteBeta(degrees / 2, 0.5, degrees / (degrees + t * t)) : 0;
}

double studentQuantile(double probability, double degrees) {
    double low = 0, high = 1;
    while (studentTwoSided(high, degrees) > probability && high < 1e12)
        high *= 2;
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        (studentTwoSided(middle, degrees) > probability ? low : high) = middle;
    }
    return high;
}

double fProbability(double f, double above, double below) {
    if (!(f > 0))
        return 0;
    if (std::min(above, below) > kManyDegrees) // where the continued fraction is too short
        return nearlyNormal(f, above, below);
    return incompleteBeta(above / 2, below / 2, above * f / (above * f + below));
}

double fQuantile(double probability, double above, double below) {
    double low = 0, high = 1;
    while (fProbability(high, above, below) < probability && high < 1e12)
        high *= 2;
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        (fProbability(middle, above, below) < probability ? low : high) = middle;
    }
    return high;
}

} // namespace cmpg
