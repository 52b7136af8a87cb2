// The window: joins the work, the interface and the presentation, and runs until it is closed.
#pragma once

#include "session/exit_status.h"
#include "session/options.h"

namespace cmpg::viewer {

// Error(Device) that names --headless where no window can be shown.
ExitStatus runViewer(const Options& options);

} // namespace cmpg::viewer
