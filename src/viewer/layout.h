// Which pictures a mode shows, and how they share the window.
#pragma once

#include "live/live_session.h"
#include "viewer/present/panel_quad.h"

#include <vector>

namespace cmpg::viewer {

// In the order they are shown. `layers`: with what the camera sees first.
std::vector<LivePicture> picturesOf(LiveMode mode, bool layers);

// Pictures of one group have the same pixels: they are zoomed and panned together.
enum class Group { Image, Parameter };
Group groupOf(LivePicture picture);

// Equal rectangles, row by row: the arrangement in which pictures of this aspect, each with `border` of its height for text, are largest.
std::vector<Rectangle> tiles(const Rectangle& area, std::size_t count, float aspect, float border, float gap);

} // namespace cmpg::viewer
