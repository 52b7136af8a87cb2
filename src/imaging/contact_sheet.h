// One picture that tells how an optimisation went: its views, its parameters at start and end, and the loss.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace cmpg {

struct ContactSheet {
    struct ViewRow {
        std::string name;                 // of the camera; may be empty
        Image target, initial, recovered; // linear, 3 channels
        Image difference;                 // of the recovered one to the target, as steps see it
    };
    struct ParameterRow {
        std::string name;
        SlotKind kind = SlotKind::BaseColor;
        Image start, end, gradient; // in the parameter's own shape; the gradient is that of the last step
    };
    static constexpr std::size_t kMostRows = 6; // of views, and of textures: the picture keeps a sensible size
    std::string title;
    std::vector<ViewRow> views;
    std::vector<ParameterRow> parameters; // textures become pictures, constants numbers
    std::vector<double> loss;
    std::vector<double> lossError; // standard error of each loss, drawn as a band; empty: not known

    // Linear RGB, for writePng. Six views, six textures and sixteen constants at most: all are in the output folder.
    Image compose() const;
};

} // namespace cmpg
