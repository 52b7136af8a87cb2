// What the user gets to read of an error, and the exit code it ends with.
#pragma once

#include "session/exit_status.h"

#include <functional>
#include <span>
#include <string>

namespace cmpg {

// A remedy with the names that its options have on the command line.
std::string withOptions(const std::string& remedy, std::span<const std::string> options);
inline std::string remedyOf(const Error& error) { return withOptions(error.remedy, error.options); }

// Message, cause and remedy on stderr.
ExitStatus explain(const Error& error);
// Runs `work`; whatever it throws is explained.
ExitStatus explainErrors(const std::function<ExitStatus()>& work);

} // namespace cmpg
