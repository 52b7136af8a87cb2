// Sums over the samples of every pixel, and the images they stand for.
#include "render/film.h"

#include <algorithm>

namespace cmpg {

Layers::Layers(int width, int height, std::uint32_t spp, std::uint32_t depths)
    : normal(width, height, 3), depth(width, height, 1), albedo(width, height, 3), samples(width, height, 1, float(spp)), guided(width, height, 1),
      dead(width, height, 1), cell(width, height, 1), lightShare(depths, cell) {}

void Layers::set(std::size_t pixel, const gpu::LayerSample& l) {
    const float hits = std::max(l.hit, 1.0f);
    for (int c = 0; c < 3; ++c) {
        normal.values[3 * pixel + c] = l.normal[c] / hits;
        albedo.values[3 * pixel + c] = l.albedo[c] / hits;
    }
    depth.values[pixel] = l.depth / hits;
    guided.values[pixel] = l.guided / hits;
    dead.values[pixel] = l.dead / hits;
    cell.values[pixel] = l.cell;
    for (std::size_t d = 0; d < lightShare.size(); ++d)
        lightShare[d].values[pixel] = l.drawn[int(d)] > 0 ? l.lightShare[int(d)] / l.drawn[int(d)] : -1.0f;
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
    Layers result(width, height, samples, layerDepths);
    for (std::size_t i = 0; i < layerSums.size(); ++i)
        result.set(i, layerSums[i]);
    return result;
}

glm::dvec4 filmSums(const gpu::FilmPixel& p) {
    glm::dvec4 sums = (glm::dvec4(p.total) + glm::dvec4(p.rest)) + (glm::dvec4(p.sum) + glm::dvec4(p.compensation));
    sums.w *= double(p.scale) * double(p.scale);
    return sums;
}

glm::dvec3 meanOf(const gpu::FilmPixel& p, std::uint32_t samples) { return glm::dvec3(filmSums(p)) / double(samples); }

} // namespace cmpg
