// Splits host work over threads in a way that does not depend on how many there are.
#pragma once

#include <cstddef>
#include <functional>

namespace cmpg {

// Calls fn(begin, end) for consecutive ranges of `grain` indices (the last may be shorter) that cover [0, count). The ranges are
// the same on every machine; only which thread runs which differs. Of several exceptions the one of the first range is rethrown.
void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t begin, std::size_t end)>& fn);

} // namespace cmpg
