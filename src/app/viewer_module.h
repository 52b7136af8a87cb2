// The window is a module of its own, loaded when asked for: without it the program needs no window library.
#pragma once

#include "app/options.h"
#include "app/exit_status.h"

namespace cmpg {

// The function the module exports, `extern "C"`. Shows the window until it is closed, explains its errors itself, and returns the exit code.
using ViewerMain = int (*)(const Options& options);
constexpr const char* kViewerMain = "cmpgViewerMain";

// Loads the module and runs it. Error(Device) that names --headless where there is none.
ExitStatus runViewerModule(const Options& options);

} // namespace cmpg
