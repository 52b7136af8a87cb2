// The window is a module of its own, loaded when asked for: without it the program needs no window library.
#pragma once

#include "session/exit_status.h"
#include "session/options.h"
#include "viewer/viewer_main.h"

namespace cmpg {

// Loads the module and runs it. Error(Device) that names --headless where there is none.
ExitStatus runViewerModule(const Options& options);

} // namespace cmpg
