// What the guide knows at a point of a picture, and where its cells lie in it.
#include "live/guide_pick.h"

#include "base/parallel.h"
#include "guiding/guide_mixture.h"
#include "imaging/guide_maps.h"
#include "live/camera_ray.h"

namespace cmpg {
namespace {

constexpr int kMapEdge = 128; // a power of two

std::shared_ptr<const Image> map(const GuideCell& cell, const std::array<double, 3>& weights) {
    return std::make_shared<const Image>(densityMap(cell, weights, kMapEdge));
}

} // namespace

LivePick pickGuide(const Scene& scene, const View& view, int x, int y, const SdTree* guide, Sampling sampling, float share) {
    LivePick pick;
    pick.x = x;
    pick.y = y;
    const std::optional<SurfaceHit> hit = castRay(scene, CameraRays(view).at(float(x) + 0.5f, float(y) + 0.5f));
    if (!hit)
        return pick;
    pick.hit = true;
    pick.position = hit->position;
    pick.normal = hit->normal;
    pick.material = scene.materials[scene.geometry.triangles[hit->triangle].material].name;
    if (!guide || guide->empty())
        return pick;
    pick.cell = guide->cellAt(hit->position);
    pick.cells = std::uint32_t(guide->cells().size());
    const auto cell = std::make_shared<const GuideCell>(guide->cells()[pick.cell]);
    const GuideMass mean = cell->records > 0 ? cell->total() * (1 / cell->records) : GuideMass{};
    pick.guide = cell;
    pick.weights = mixtureOfCameraPath(sampling, mean);
    const double light = pick.weights[0] * mean.primal, all = light + pick.weights[1] * mean.plus + pick.weights[2] * mean.minus;
    pick.lightShare = all > 0 ? light / all : 0;
    pick.guideShare = all > 0 ? double(share) : 0;
    pick.maps = {map(*cell, {1, 0, 0}), map(*cell, {0, 1, 0}), map(*cell, {0, 0, 1}), map(*cell, pick.weights)};
    return pick;
}

Image cellPicture(const SdTree& guide, const View& view, const Image& depth) {
    Image cells(view.width, view.height, 1, -1);
    const CameraRays rays(view);
    parallelFor(std::size_t(view.height), 16, [&](std::size_t begin, std::size_t end) {
        for (int y = int(begin); y < int(end); ++y)
            for (int x = 0; x < view.width; ++x) {
                const float distance = *depth.at(x, y);
                if (!(distance > 0))
                    continue;
                const CameraRays::Ray ray = rays.at(float(x) + 0.5f, float(y) + 0.5f);
                *cells.at(x, y) = float(guide.cellAt(ray.origin + distance * ray.direction));
            }
    });
    return cells;
}

} // namespace cmpg
