// Colours for data from nothing to a highest value.
#include "app/heat_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

Color heatColor(double t) {
    static constexpr int kStops[][3] = {{24, 16, 60}, {88, 22, 118}, {186, 48, 92}, {243, 138, 46}, {255, 246, 200}};
    const double place = std::clamp(t, 0.0, 1.0) * 4;
    const int stop = std::min(int(place), 3);
    const auto channel = [&](int c) { return int(std::lround(kStops[stop][c] + (place - stop) * (kStops[stop + 1][c] - kStops[stop][c]))); };
    return displayColor(channel(0), channel(1), channel(2));
}

} // namespace cmpg
