// Sums over the samples of every pixel, and the images they stand for.
#include "render/film.h"

#include <algorithm>

namespace cmpg {

Layers emptyLayers(int width, int height, std::uint32_t spp, std::uint32_t depths) {
    const Image plane(width, height, 1);
    return {.normal = Image(width, height, 3),
            .depth = plane,
            .albedo = Image(width, height, 3),
            .samples = Image(width, height, 1, float(spp)),
            .guided = plane,
            .dead = plane,
            .cell = plane,
            .lightShare = std::vector<Image>(depths, plane)};
}

void setLayers(Layers& layers, std::size_t pixel, const gpu::LayerSample& sums) {
    const float hits = std::max(sums.hit, 1.0f);
    for (int c = 0; c < 3; ++c) {
        layers.normal.values[3 * pixel + c] = sums.normal[c] / hits;
        layers.albedo.values[3 * pixel + c] = sums.albedo[c] / hits;
    }
    layers.depth.values[pixel] = sums.depth / hits;
    layers.guided.values[pixel] = sums.guided / hits;
    layers.dead.values[pixel] = sums.dead / hits;
    layers.cell.values[pixel] = sums.cell;
    for (std::size_t d = 0; d < layers.lightShare.size(); ++d)
        layers.lightShare[d].values[pixel] = sums.drawn[int(d)] > 0 ? sums.lightShare[int(d)] / sums.drawn[int(d)] : -1.0f;
}

Film::Film(int w, int h, bool layers) : width(w), height(h), pixels(std::size_t(w) * h), layerSums(layers ? std::size_t(w) * h : 0) {}

Image Film::image() const {
    Image result(width, height, 3);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const glm::dvec3 mean = meanOf(pixels[i], samples);
        for (int c = 0; c < 3; ++c)
            result.values[3 * i + c] = float(mean[c]);
    }
    return result;
}

Layers Film::layers() const {
    Layers result = emptyLayers(width, height, samples, layerDepths);
    for (std::size_t i = 0; i < layerSums.size(); ++i)
        setLayers(result, i, layerSums[i]);
    return result;
}

glm::dvec4 filmSums(const gpu::FilmPixel& p) {
    glm::dvec4 sums = (glm::dvec4(p.total) + glm::dvec4(p.rest)) + (glm::dvec4(p.sum) + glm::dvec4(p.compensation));
    sums.w *= double(p.scale) * double(p.scale);
    return sums;
}

glm::dvec3 meanOf(const gpu::FilmPixel& p, std::uint32_t samples) { return glm::dvec3(filmSums(p)) / double(samples); }

} // namespace cmpg
