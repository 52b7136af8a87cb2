// What the guide knows at a point of a picture, and where its cells lie in it.
#pragma once

#include "live/live_session.h"

namespace cmpg {

class SdTree;

// `guide`: null or empty where nothing has been learned. `sampling`: the method whose mixture is shown; Bsdf: that of conditional
// sampling, since a guide that learned for its user's eyes is drawn from by nobody. `share`: of directions, drawn from it.
LivePick pickGuide(const Scene& scene, const View& view, int x, int y, const SdTree* guide, Sampling sampling, float share);

// Number of the cell at the first hit of every pixel, from its depth layer; -1 where nothing was hit.
Image cellPicture(const SdTree& guide, const View& view, const Image& depth);

} // namespace cmpg
