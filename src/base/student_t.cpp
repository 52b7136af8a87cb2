// Student's t and the F distribution, by Boost.Math.
#include "base/student_t.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace cmpg {
namespace {

// What makes no sense is not a number; nothing is thrown.
namespace policies = boost::math::policies;
using Quiet = policies::policy<policies::domain_error<policies::ignore_error>, policies::pole_error<policies::ignore_error>,
                               policies::overflow_error<policies::ignore_error>, policies::evaluation_error<policies::ignore_error>>;
using Student = boost::math::students_t_distribution<double, Quiet>;
using Fisher = boost::math::fisher_f_distribution<double, Quiet>;

} // namespace

double studentTwoSided(double t, double degrees) { return std::isfinite(t) ? 2 * cdf(complement(Student(degrees), std::abs(t))) : 0; }

double studentQuantile(double probability, double degrees) { return quantile(complement(Student(degrees), probability / 2)); }

double fProbability(double f, double above, double below) { return f > 0 ? cdf(Fisher(above, below), f) : 0; }

double fQuantile(double probability, double above, double below) { return quantile(Fisher(above, below), probability); }

} // namespace cmpg
