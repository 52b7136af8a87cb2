// From arguments to options.
#pragma once

#include "session/options.h"

namespace cmpg {

// Reads the configuration of the run to resume, --config and the command line, in this order, and checks the result. Throws Error(Usage), or HelpRequested.
Options parseOptions(int argc, const char* const* argv);

struct HelpRequested {
    std::string text;
};

} // namespace cmpg
