// Speed against accuracy: a point per setting, both axes logarithmic, the frontier as a line; as an SVG and as a picture.
#pragma once

#include "scene/image.h"

#include <string>
#include <vector>

namespace cmpg {

struct ParetoPoint {
    std::string name;
    double seconds = 0, error = 0; // those not above 0 are left out
    std::size_t group = 0;         // settings of one group have a colour
    bool biased = false;           // drawn hollow
};

struct ParetoPlot {
    std::string title, across, up;      // of the axes
    std::vector<ParetoPoint> points;    // the first is larger: the defaults
    std::vector<std::size_t> frontier;  // indices into points, from left to right
    std::string svg() const; // a file
    Image png() const;       // linear RGB
};

} // namespace cmpg
