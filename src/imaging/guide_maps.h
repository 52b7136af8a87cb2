// Pictures of what one cell of a guide would draw from.
#pragma once

#include "imaging/color.h"

#include <array>
#include <functional>

namespace cmpg {

// What a picture says of a cell of a guide.
struct DrawnCell {
    std::uint32_t number = 0;
    double weight = 0;               // of its records
    std::array<double, 3> means{};   // of P, D+ and D-, per record
    std::array<double, 2> weights{}; // wL and wD, of the mixture wL P + wD (D+ + D-)
    // Density of a mixture of P, D+ and D- over that of uniform directions, edge x edge: azimuth across, z up.
    std::function<Image(const std::array<double, 3>& mixture, int edge)> density;
};

// P, D+, D- and the mixture side by side, logarithmic false colours, each with its scale.
Image drawCell(const DrawnCell& cell);

} // namespace cmpg
