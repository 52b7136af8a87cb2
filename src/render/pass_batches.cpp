// The division of a pass into batches.
#include "render/pass_batches.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

static_assert(std::uint32_t(PixelFilter::Kind::Box) == gpu::kFilterBox && std::uint32_t(PixelFilter::Kind::Tent) == gpu::kFilterTent &&
              std::uint32_t(PixelFilter::Kind::Gaussian) == gpu::kFilterGaussian);

void placeCamera(gpu::Batch& b, const View& view) {
    const Camera& c = *view.camera;
    const float aspect = float(view.width) / float(view.height);
    const float halfHeight = c.orthographic ? c.ymag : std::tan(0.5f * c.yfov);
    const glm::mat3 axes(c.toWorld);
    b.cameraOrigin = glm::vec3(c.toWorld[3]);
    b.cameraRight = glm::normalize(axes[0]) * halfHeight * aspect;
    b.cameraUp = glm::normalize(axes[1]) * halfHeight;
    b.cameraForward = -glm::normalize(axes[2]);
    if (c.center != glm::vec2(0)) {
        const glm::vec3 across = (glm::normalize(axes[0]) * c.center.x + b.cameraUp / halfHeight * c.center.y) * halfHeight;
        (c.orthographic ? b.cameraOrigin : b.cameraForward) += across;
    }
    b.orthographic = c.orthographic;
    b.filterKind = std::uint32_t(c.filter.kind);
    b.filterRadius = c.filter.radius;
    b.filterDeviation = c.filter.deviation;
}

} // namespace

PassInput passInput(const View& view, const PassKey& key, std::uint32_t spp) {
    PassInput in;
    in.view = view;
    in.key = key;
    in.width = std::uint32_t(view.width);
    in.height = std::uint32_t(view.height);
    in.spp = spp;
    return in;
}

gpu::Batch nextBatch(const PassInput& in, std::uint32_t most, std::size_t end, BatchStart& start, std::vector<std::uint32_t>& offsets) {
    gpu::Batch batch{};
    batch.seed = {std::uint32_t(in.key.seed), std::uint32_t(in.key.seed >> 32)};
    batch.step = in.key.step;
    batch.pass = in.key.pass;
    batch.firstPixel = std::uint32_t(start.pixel);
    batch.firstSample = start.sample;
    batch.width = in.width;
    batch.height = in.height;
    batch.surfaceScale = in.surfaceScale;
    batch.normalScale = in.normalScale;
    batch.emissionScale = in.emissionScale;
    batch.sign = in.plan.sign;
    batch.allLight = in.pilot;
    placeCamera(batch, in.view);
    offsets.clear();
    bool split = false; // the last pixel goes on in the next batch
    while (start.pixel < end && !split && batch.paths < most && offsets.size() < most) {
        const std::uint32_t left = in.samples(start.pixel) - start.sample;
        const std::uint32_t take = std::min({left, most - batch.paths, gpu::kMaxPixelSamples});
        offsets.push_back(batch.paths);
        batch.paths += take;
        split = take < left;
        start.sample = split ? start.sample + take : 0;
        start.pixel += split ? 0 : 1;
    }
    batch.pixels = std::uint32_t(offsets.size());
    offsets.push_back(batch.paths);
    return batch;
}

std::vector<glm::vec3> adjointTile(const PassInput& in, const gpu::Batch& batch) {
    std::vector<glm::vec3> tile(batch.pixels, glm::vec3(0));
    if (!in.adjoint)
        return tile;
    for (std::size_t i = 0; i < tile.size(); ++i) {
        const std::size_t p = batch.firstPixel + i;
        const float weight = in.weights.empty() ? 1.0f / float(in.spp) : in.weights[p];
        const float* a = &in.adjoint->values[3 * p];
        tile[i] = glm::vec3(a[0], a[1], a[2]) * weight;
    }
    return tile;
}

} // namespace cmpg
