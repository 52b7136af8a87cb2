// The options of a recovery as the library has them, as the configuration of an optimisation.
#pragma once

#include "optimize/optimize.h"

#include <cmpg/recovery.h>

namespace cmpg {

// Without targets. Error(Usage) on rates of slots that there are not; the caller has checked all ranges.
OptimizeConfig configOf(const v1::RecoveryOptions& options);

} // namespace cmpg
