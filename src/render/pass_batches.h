// What a pass computes, and its division into batches: samples in pixel order, as many as the pools hold.
#pragma once

#include "render/film.h"
#include "render/first_vertices.h"
#include "render/renderer.h"
#include "shared/batch.h"

namespace cmpg {

struct PassInput {
    View view;
    PassKey key;
    std::uint32_t width = 0, height = 0; // of the pixel grid, normally the view's
    std::uint32_t spp = 0;
    std::span<const std::uint32_t> perPixel; // samples of each pixel; empty: spp
    std::span<const std::uint32_t> firsts;   // of their sequences; empty: key.firstSample
    const Image* adjoint = nullptr;
    std::span<const float> weights; // of the adjoint, per pixel; empty: 1 / spp
    glm::vec2 surfaceScale{1}, normalScale{1}, emissionScale{1};
    PassPlan plan;
    const Film* film = nullptr; // whose sums the pass continues
    FirstVertices* firstVertices = nullptr; // to be filled in; reverse mode
    bool pilot = false;         // nothing but the image is of use: no records, no figures

    std::uint32_t samples(std::size_t pixel) const { return perPixel.empty() ? spp : perPixel[pixel]; }
    std::uint32_t first(std::size_t pixel) const { return film ? film->samples : firsts.empty() ? key.firstSample : firsts[pixel]; }
};

PassInput passInput(const View& view, const PassKey& key, std::uint32_t spp);

// Where a batch begins: `sample` of the samples of `pixel` were in earlier batches.
struct BatchStart {
    std::size_t pixel = 0;
    std::uint32_t sample = 0;
};

// A batch of at most `most` paths of pixels before `end` from `start` on, which moves to what comes next. offsets[i]: first path of its pixel i; one more,
// the end.
gpu::Batch nextBatch(const PassInput& in, std::uint32_t most, std::size_t end, BatchStart& start, std::vector<std::uint32_t>& offsets);

// The adjoint of a batch's pixels, for one sample each.
std::vector<glm::vec3> adjointTile(const PassInput& in, const gpu::Batch& batch);

// What a batch adds to: sums of earlier passes, and of an earlier batch where it begins within a pixel.
template <class Sums>
void beginTile(std::vector<Sums>& tile, const gpu::Batch& batch, const std::vector<Sums>* film, const Sums& carry) {
    if (film)
        tile.assign(film->begin() + batch.firstPixel, film->begin() + batch.firstPixel + batch.pixels);
    else
        tile.assign(batch.pixels, {});
    if (batch.firstSample > 0)
        tile[0] = carry;
}

} // namespace cmpg
