// The methods a comparison sets side by side: names of what draws directions.
#pragma once

#include "session/options.h"

#include <string>
#include <vector>

namespace cmpg {

struct CompareMethod {
    std::string name; // as given
    Options options;  // those of the comparison, and what the method changes in them

    bool learns() const { return options.sampling != Sampling::Bsdf || options.roulette; }
    std::string describe() const; // in words
};

// NAME[+PART...], comma-separated. Names:
//   plain, bsdf                                   materials and lights alone, uniform pixels, no roulette
//   primal, differential, uniform, conditional    that guide, uniform pixels, no roulette
//   ours, auto                                    the program's defaults: chosen guide, pixels by the adjoint, gated roulette
// Parts: pixels, roulette, positivize, nee, sobol, independent, and no<part> of the first four to take them away.
// `base`: what all else is. Error(Usage) on unknown or repeated names.
std::vector<CompareMethod> parseMethods(const std::string& list, const Options& base);

} // namespace cmpg
