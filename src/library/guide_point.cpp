// What a guide knows, as the library's surface tells it.
#include "library/guide_point.h"

#include "base/parallel.h"
#include "guiding/field/density_map.h"
#include "guiding/guide_mixture.h"
#include "library/states.h"

#include <bit>

namespace cmpg::v1 {

GuidePoint guidePoint(const SdTree& guide, glm::vec3 position, Sampling sampling, float share) {
    GuidePoint point;
    point.cell = guide.cellAt(position);
    point.cells = std::uint32_t(guide.cells().size());
    const GuideCell& cell = guide.cells()[point.cell];
    const GuideMass mean = cell.records > 0 ? cell.total() * (1 / cell.records) : GuideMass{};
    point.records = cell.records;
    point.weight = cell.weight();
    point.means = {mean.primal, mean.plus, mean.minus};
    point.weights = mixtureOfCameraPath(sampling, mean);
    const double light = point.weights[0] * mean.primal, all = light + point.weights[1] * mean.plus + point.weights[2] * mean.minus;
    point.lightShare = all > 0 ? light / all : 0;
    point.guideShare = all > 0 ? double(share) : 0;
    point.state = std::make_shared<const GuidePoint::State>(cell);
    return point;
}

Image densityOf(const GuideCell& cell, const std::array<double, 3>& mixture, int edge) {
    require(edge >= 2 && edge <= 4096 && std::has_single_bit(unsigned(edge)), "edge", "a power of two, from 2 to 4096");
    return densityMap(cell, mixture, edge);
}

Image GuidePoint::density(const std::array<double, 3>& mixture, int edge) const {
    static const GuideCell kEmpty{.nodes = std::vector<QuadNode>(1)};
    return densityOf(state ? state->cell : kEmpty, mixture, edge);
}

Image cellNumbers(const SdTree& guide, const CameraRays& rays, const Image& depth) {
    Image cells(depth.width, depth.height, 1, -1);
    parallelFor(std::size_t(depth.height), 16, [&](std::size_t begin, std::size_t end) {
        for (int y = int(begin); y < int(end); ++y)
            for (int x = 0; x < depth.width; ++x) {
                const float distance = *depth.at(x, y);
                if (!(distance > 0))
                    continue;
                const CameraRays::Ray ray = rays.at(float(x) + 0.5f, float(y) + 0.5f);
                *cells.at(x, y) = float(guide.cellAt(ray.origin + distance * ray.direction));
            }
    });
    return cells;
}

} // namespace cmpg::v1
