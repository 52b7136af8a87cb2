// What the user gets to read of an error, and the exit code it ends with.
#pragma once

#include "base/error.h"

#include <functional>

namespace cmpg {

// Message, cause and remedy on stderr.
ExitCode explain(const Error& error);
// Runs `work`; whatever it throws is explained.
ExitCode explainErrors(const std::function<ExitCode()>& work);

} // namespace cmpg
