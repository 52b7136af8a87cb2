// Errors over time, both axes logarithmic.
#pragma once

#include "imaging/drawing.h"
#include "imaging/plot_axes.h"

#include <optional>
#include <string>
#include <vector>

namespace cmpg {

struct ErrorCurve {
    std::string name;
    std::vector<std::pair<double, double>> points; // seconds, error; those not above 0 are left out
};

struct ErrorPlot {
    std::string title, vertical;       // what the error is of
    std::vector<ErrorCurve> curves;
    std::optional<double> floor;       // an error below which nothing is known
    std::string floorName;
    void draw(Drawing& drawing) const;
    std::string svg() const; // a file
    Image picture() const;
};

// Grid, frame and names of two logarithmic axes.
void drawLogAxes(Drawing& drawing, const LogAxis& across, const LogAxis& up, const std::string& below, const std::string& beside);

// Colour of a curve, "#rrggbb": tell apart with every common kind of colour blindness (Okabe and Ito 2008).
std::string curveColor(std::size_t index);

} // namespace cmpg
