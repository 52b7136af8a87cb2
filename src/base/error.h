// The one exception type, which is that of the library.
#pragma once

#include <cmpg/error.h>

namespace cmpg {

using ExitCode = ErrorKind; // its former name, which the passes of src/render still say

} // namespace cmpg
