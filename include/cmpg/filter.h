// Reconstruction filters: how a pixel weighs what the picture shows around its middle.
#pragma once

#include <cmpg/namespace.h>

#include <string>

namespace cmpg::v1 {

// Of all cameras of a scene, along x and along y, normalised within the picture (docs/conventions.md, Cameras).
struct ReconstructionFilter {
    enum class Kind {
        Box,      // the mean over the pixel's square
        Tent,     // 1 - |x| / width
        Gaussian, // of that deviation, less its value at four of them, where it ends
    };
    Kind kind = Kind::Box;
    // In pixels: a tent's radius, from 0.01 to 32, or a Gaussian's standard deviation, from 0.01 to 8; 0: 1 and 0.5, as in Mitsuba. A box has none.
    double width = 0;

    // "box", "tent", "tent:WIDTH", "gaussian" or "gaussian:WIDTH". Error(Usage) on everything else.
    static ReconstructionFilter parse(const std::string& text);
};

} // namespace cmpg::v1
