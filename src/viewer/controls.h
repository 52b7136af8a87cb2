// The panel on the left: everything that can be set, and the figures of the work.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

float controlsWidth();
void drawControls(Desk& desk, const Rectangle& area);

} // namespace cmpg::viewer
