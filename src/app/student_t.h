// Student's t distribution: how surprising a deviation is when its standard error was itself estimated from few samples.
#pragma once

namespace cmpg {

// P(|T| >= |t|) with `degrees` > 0 degrees of freedom.
double studentTwoSided(double t, double degrees);
// The t >= 0 with P(|T| >= t) = `probability`, in (0,1).
double studentQuantile(double probability, double degrees);

} // namespace cmpg
