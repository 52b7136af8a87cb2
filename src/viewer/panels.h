// The pictures: captions, values under the cursor, legends, and what the mouse does in them.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

// Into the given part of the window. What is to be drawn under the interface is added to `quads`, in the interface's units.
void drawPanels(Desk& desk, const Rectangle& area, std::vector<PanelQuad>& quads);

} // namespace cmpg::viewer
