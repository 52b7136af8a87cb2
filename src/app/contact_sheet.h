// One picture that tells how an optimisation went: target, initial, recovered, signed gradient, loss curve.
#pragma once

#include "scene/image.h"

#include <string>
#include <vector>

namespace cmpg {

struct ContactSheet {
    struct ViewRow {
        std::string name;                 // of the camera; may be empty
        Image target, initial, recovered; // linear, 3 channels
    };
    struct GradientPanel {
        std::string name; // of the parameter
        Image gradient;   // in the parameter's own shape
    };
    std::string title;
    std::vector<ViewRow> views;           // one row each
    std::vector<GradientPanel> gradients; // shown beside the rows, as many as there is room for
    std::vector<double> loss;

    Image compose() const; // linear RGB, for writePng
};

} // namespace cmpg
