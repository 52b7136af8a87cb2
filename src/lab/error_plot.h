// Errors over time, both axes logarithmic, as an SVG.
#pragma once

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
    std::string svg() const; // an element of a page; no script, nothing loaded
};

// The same as a file of its own.
std::string svgFile(std::string svg);

// Colour of a curve, "#rrggbb": tell apart with every common kind of colour blindness (Okabe and Ito 2008).
std::string curveColor(std::size_t index);

} // namespace cmpg
