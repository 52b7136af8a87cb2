// Student's t and the F distribution, by DCDFLIB (Brown, Lovato and Russell 1994), which Debian has as libnifticdf: 0.4 MB, where Boost.Math is 135.
#include "base/student_t.h"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
extern "C" {
#include <nifti/nifticdf.h>
}

namespace cmpg {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN(); // what makes no sense is not a number
constexpr int kFindValue = 2;                                      // of a given probability

// Its searches keep their state in static variables.
std::mutex& library() {
    static std::mutex mutex;
    return mutex;
}

bool isProbability(double p) { return p > 0 && p < 1; }

bool isDegrees(double degrees) { return degrees > 0 && std::isfinite(degrees); }

} // namespace

double studentTwoSided(double t, double degrees) {
    if (std::isnan(t))
        return kNone;
    if (std::isinf(t))
        return 0;
    if (!isDegrees(degrees))
        return kNone;
    const std::lock_guard lock(library());
    double below = 0, above = 0;
    t = std::abs(t);
    cumt(&t, &degrees, &below, &above);
    return 2 * above;
}

double studentQuantile(double probability, double degrees) {
    if (!isProbability(probability) || !isDegrees(degrees))
        return kNone;
    const std::lock_guard lock(library());
    double above = probability / 2, below = 1 - above, t = 0, bound = 0;
    int status = 0;
    cdft(&kFindValue, &below, &above, &t, &degrees, &status, &bound);
    return status == 0 ? t : kNone;
}

double fProbability(double f, double above, double below) {
    if (!(f > 0))
        return 0;
    if (!isDegrees(above) || !isDegrees(below))
        return kNone;
    const std::lock_guard lock(library());
    double smaller = 0, larger = 0;
    cumf(&f, &above, &below, &smaller, &larger);
    return smaller;
}

double fQuantile(double probability, double above, double below) {
    if (!isProbability(probability) || !isDegrees(above) || !isDegrees(below))
        return kNone;
    const std::lock_guard lock(library());
    double larger = 1 - probability, f = 0, bound = 0;
    int status = 0;
    cdff(&kFindValue, &probability, &larger, &f, &above, &below, &status, &bound);
    return status == 0 ? f : kNone;
}

} // namespace cmpg
