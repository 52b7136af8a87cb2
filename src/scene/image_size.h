// The size of an image that a camera takes.
#pragma once

#include "scene/scene.h"

namespace cmpg {

// Width over height of its picture in the file; empty: the file says nothing of it.
std::optional<double> aspectOf(const Camera& camera);

// Width and height in pixels: as given; one that is not follows from the other by the camera's aspect ratio; without either the image is
// `defaultWidth` wide. Error(Usage) beyond 2^28 pixels, as many as images that are read may have.
std::pair<int, int> imageSize(const Camera& camera, std::optional<std::uint32_t> width, std::optional<std::uint32_t> height, int defaultWidth);

} // namespace cmpg
