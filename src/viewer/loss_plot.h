// The loss over the steps, drawn with Dear ImGui.
#pragma once

#include "viewer/present/panel_quad.h"

#include <span>

namespace cmpg::viewer {

void drawLossPlot(const Rectangle& area, std::span<const double> loss);

} // namespace cmpg::viewer
