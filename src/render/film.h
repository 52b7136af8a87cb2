// Sums over the samples of every pixel, which passes continue: any split of N samples into passes leaves the bits of one pass of N.
#pragma once

#include "scene/image.h"
#include "shared/film.h"

#include <cmpg/report.h>

#include <cstdint>
#include <vector>

namespace cmpg {

// Images of a view's size, for the means of `spp` samples; `depths` of Layers::lightShare.
Layers emptyLayers(int width, int height, std::uint32_t spp, std::uint32_t depths);
void setLayers(Layers& layers, std::size_t pixel, const gpu::LayerSample& sums);

struct Film {
    int width = 0, height = 0;
    std::uint32_t samples = 0;             // per pixel so far
    std::vector<gpu::FilmPixel> pixels;
    std::vector<gpu::LayerSample> layerSums; // empty: no layers
    std::uint32_t layerDepths = 0;           // that Layers::lightShare has

    Film() = default;
    Film(int width, int height, bool layers = false);
    bool hasLayers() const { return !layerSums.empty(); }
    // Both need samples > 0.
    Image image() const;
    Layers layers() const;
};

// Sums over a pixel's samples of the value, and in w of mean_rgb of the value squared.
glm::dvec4 filmSums(const gpu::FilmPixel& pixel);
glm::dvec3 meanOf(const gpu::FilmPixel& pixel, std::uint32_t samples);

} // namespace cmpg
