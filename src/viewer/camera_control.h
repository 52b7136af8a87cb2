// Moving a camera: around a point, sideways, towards a point, and flying. World up is +y.
#pragma once

#include <cmpg/scene.h>

#include <glm/glm.hpp>

namespace cmpg::viewer {

using Camera = v1::CameraInfo;

glm::mat4 poseOf(const Camera& camera); // Camera::toWorld
void setPose(Camera& camera, const glm::mat4& pose);
glm::vec3 eyeOf(const Camera& camera);
glm::vec3 forwardOf(const Camera& camera);

// A point to turn about, before anything was clicked: straight ahead, as far as the middle of the scene's box.
glm::vec3 pivotAhead(const Camera& camera, glm::vec3 lower, glm::vec3 upper);

// Angles in radians. The horizon stays level, and the view never turns over.
void orbit(Camera& camera, glm::vec3 pivot, float yaw, float pitch);
// By a distance in world units, along the camera's own axes: right, up, forward.
void slide(Camera& camera, glm::vec3 distance);
// `factor` of the distance to the pivot remains; an orthographic camera sees as much less.
void approach(Camera& camera, glm::vec3 pivot, float factor);

} // namespace cmpg::viewer
