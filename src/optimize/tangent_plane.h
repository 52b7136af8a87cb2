// Steps of normals, each in the plane at right angles to it.
#pragma once

#include <cstddef>
#include <span>

namespace cmpg {

// `normals`: three components for each texel, of any length. What is said by steps has as many entries: of each texel along its two axes, in units of the
// normal's length, and a third that is 0.

// Derivatives by the components become derivatives by such steps.
void toSteps(std::span<const float> normals, std::span<double> derivatives);
// Of derivatives by steps: 0 along the other axis than `axis`, 0 or 1.
void dropOtherAxis(std::size_t axis, std::span<double> derivatives);

// Takes the steps; normals are unit then.
void moveNormals(std::span<const float> steps, std::span<float> normals);

} // namespace cmpg
