// What the guide knows at the point that was clicked: maps of the sphere and figures, in a column beside the pictures.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

// Width of the column; 0 while it is closed.
float inspectorWidth(const Desk& desk, const Rectangle& area);
void drawInspector(Desk& desk, const Rectangle& area, std::vector<PanelQuad>& quads);

} // namespace cmpg::viewer
