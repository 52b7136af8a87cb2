// Targets of the library's surface as recoveries take them.
#pragma once

#include "optimize/target.h"

#include <cmpg/recovery.h>

namespace cmpg::v1 {

// `number`: of the target, its name where it has none. Pixels that are not finite have weight 0. Error(Usage or Input) on what is no target.
cmpg::Target targetOf(const Target& target, std::size_t number);

} // namespace cmpg::v1
