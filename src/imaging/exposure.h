// One exposure for pictures that are to be compared.
#pragma once

#include "scene/image.h"

#include <vector>

namespace cmpg {

// A factor that makes the 95th percentile of all values, which leaves out lamps, white where it is not between 0.5 and 1 already.
float exposureFor(const std::vector<const Image*>& images);

} // namespace cmpg
