// Zoom and pan: which part of a picture stands where in its panel. Panels of one group share it.
#pragma once

#include "viewer/present/panel_quad.h"

#include <optional>

namespace cmpg::viewer {

struct PictureView {
    double zoom = 1;             // 1: the whole picture fits
    glm::dvec2 center{0.5, 0.5}; // of the panel, in units of the picture's extent

    bool operator==(const PictureView&) const = default;
};

// Where the whole picture stands: on whole pixels, and at whole multiples where the scale is close to one, so that it is shown exactly.
Rectangle placeOf(const PictureView& view, int width, int height, const Rectangle& area);
// The pixel of the picture under a point, if any.
std::optional<glm::ivec2> pixelAt(glm::vec2 point, int width, int height, const Rectangle& place);

void zoomAbout(PictureView& view, double factor, glm::vec2 point, int width, int height, const Rectangle& area);
void panBy(PictureView& view, glm::vec2 distance, int width, int height, const Rectangle& area);
// One pixel of the picture to one of the window.
void showActualSize(PictureView& view, int width, int height, const Rectangle& area);

} // namespace cmpg::viewer
