// What a guide knows, as the library's surface tells it.
#pragma once

#include "guiding/field/sd_tree.h"
#include "scene/camera_ray.h"

#include <cmpg/renderer.h>

namespace cmpg::v1 {

struct GuidePoint::State {
    GuideCell cell;
};

// `sampling`: the method whose mixture it is; Bsdf: that of conditional sampling, since a guide that learned for its user's eyes is drawn from by nobody.
// `share`: of directions, drawn from the guide.
GuidePoint guidePoint(const SdTree& guide, glm::vec3 position, Sampling sampling, float share);

// What a cell would draw from, as GuidePoint::density. Error(Usage) on another edge.
Image densityOf(const GuideCell& cell, const std::array<double, 3>& mixture, int edge);

// Number of the cell at the first hit of every pixel, from its depth; -1 where nothing was hit.
Image cellNumbers(const SdTree& guide, const CameraRays& rays, const Image& depth);

} // namespace cmpg::v1
