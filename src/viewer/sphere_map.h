// Directions on the maps of the guide, and where they lead in the image.
#pragma once

#include "viewer/camera_control.h"

#include <cmpg/image.h>

#include <optional>

namespace cmpg::viewer {

// The map is the equal-area square of all directions: azimuth across, z up, row 0 on top.
glm::vec3 directionAt(glm::vec2 place);     // `place` in [0,1]^2, y down
glm::vec2 placeOfDirection(glm::vec3 direction); // the inverse; unit length in
// The middle of the brightest pixel; none where all are 0.
std::optional<glm::vec2> brightest(const Image& map);

// Where a point stands in an image of this size, in pixels; none behind the camera.
std::optional<glm::vec2> project(const Camera& camera, glm::vec3 point, int width, int height);

} // namespace cmpg::viewer
