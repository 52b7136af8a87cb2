// The loss over the steps of an optimisation, as an SVG and as a part of a drawing.
#pragma once

#include "imaging/drawing.h"

#include <span>
#include <string>
#include <vector>

namespace cmpg {

// Axes of a curve: logarithmic where all finite values are positive and span more than a factor of 3, linear otherwise.
struct CurveAxes {
    bool logarithmic = false;
    double low = 0, high = 1;  // of the vertical axis, in units of the loss
    std::vector<double> ticks; // on the vertical axis
    double steps = 1;          // end of the horizontal axis

    double across(double step) const; // 0 at the left, 1 at the right
    double up(double value) const;    // 0 at the bottom, 1 at the top
};
CurveAxes axesOf(std::span<const double> loss);

// `error`: standard error of each value, drawn as a band of one above and below; empty: none is known.
void drawLossCurve(Drawing& drawing, int x, int y, int width, int height, std::span<const double> loss, std::span<const double> error = {});
std::string lossCurveSvg(std::span<const double> loss, const std::string& title, std::span<const double> error = {});

} // namespace cmpg
