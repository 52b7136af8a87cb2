// Student's t and the F distribution: how surprising a deviation is when its standard error was itself estimated from few samples.
#pragma once

namespace cmpg {

// P(|T| >= |t|) with `degrees` > 0 degrees of freedom; NaN of a t that is.
double studentTwoSided(double t, double degrees);
// The t >= 0 with P(|T| >= t) = `probability`, in (0,1).
double studentQuantile(double probability, double degrees);

// P(F <= f) of the quotient of two mean squares with these degrees of freedom, and the f where it is `probability`, in (0,1).
double fProbability(double f, double above, double below);
double fQuantile(double probability, double above, double below);

} // namespace cmpg
