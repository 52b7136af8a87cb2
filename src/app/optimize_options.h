// The options of an optimisation as its configuration.
#pragma once

#include "app/options.h"
#include "optimize/optimize.h"

namespace cmpg {

// Without targets. Error(Usage) on rates that mean nothing.
OptimizeConfig optimizeConfig(const Options& options);

} // namespace cmpg
