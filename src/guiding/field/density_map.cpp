// What one cell of a guide would draw from, as an image.
#include "guiding/field/density_map.h"

#include <algorithm>

namespace cmpg {

Image densityMap(const GuideCell& cell, const std::array<double, 3>& weights, int edge) {
    const auto score = [&](const GuideMass& m) { return weights[0] * m.primal + weights[1] * m.plus + weights[2] * m.minus; };
    const double all = score(cell.total());
    Image map(edge, edge, 1);
    if (!(all > 0))
        return map;
    // A quadrant as wide as a pixel has the pixel's mass, its own children included; a wider leaf has its density throughout.
    const auto fill = [&](const auto& self, std::uint32_t node, int x, int y, int width) -> void {
        const int half = width / 2;
        for (std::uint32_t q = 0; q < 4; ++q) {
            const int left = x + int(q % 2) * half, low = y + int(q / 2) * half;
            if (half > 1 && cell.nodes[node].child[q]) {
                self(self, cell.nodes[node].child[q], left, low, half);
                continue;
            }
            const double area = double(half) * half / (double(edge) * edge);
            const auto density = float(score(cell.nodes[node].mass[q]) / all / area);
            for (int j = low; j < low + half; ++j)
                std::fill_n(map.at(left, edge - 1 - j), half, density); // row 0 is the top: z = 1
        }
    };
    fill(fill, 0, 0, 0, edge);
    return map;
}

} // namespace cmpg
