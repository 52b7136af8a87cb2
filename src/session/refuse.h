// Ends the program for options that make no sense.
#pragma once

#include "base/error.h"

#include <string>

namespace cmpg {

[[noreturn]] inline void refuse(const std::string& what, const std::string& remedy = "") { throw Error(ErrorKind::Usage, what, "", remedy); }

} // namespace cmpg
