// Sums the samples of each pixel of the batch in their order, on top of what earlier batches left.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "scene/features.glsl"
#include "shared/bindings.h"
#include "shared/batch.h"
#include "shared/wavefront.h"
#include "lib/read_buffers.glsl"
#include "shared/tape.h"
#include "lib/film_sum.glsl"
#include "lib/dispatch.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindBatch, scalar) uniform BatchBlock { Batch batch; };
QUEUE_UINT(pixelOffset, kBindPixelOffsets) // as in generate_rays
QUEUE_UVEC4(suffixTexel, kBindSuffixes)
QUEUE_UVEC4(tangentTexel, kBindTangents)
layout(binding = kBindFilm, scalar) buffer Film { FilmPixel film[]; };
layout(binding = kBindDifferenceFilm, scalar) buffer DifferenceFilm { FilmPixel differenceFilm[]; };
layout(binding = kBindStatistics, scalar) buffer StatisticsBlock { uint statistics[]; };
layout(binding = kBindLayers, scalar) readonly buffer Layers { LayerSample layers[]; };
layout(binding = kBindLayerFilm, scalar) buffer LayerFilm { LayerSample layerFilm[]; };

void main() {
    const uint pixel = globalIndex();
    if (push.count == 0 || pixel >= batch.pixels) return;
    FilmPixel p = film[pixel];
    const uint first = pixelOffset(pixel), end = pixelOffset(pixel + 1); // at most kMaxPixelSamples apart
    const uint sample0 = pixelOffset(batch.pixels + 1 + pixel) + (pixel == 0 ? batch.firstSample : 0);
    for (uint path = first; path < end; ++path) {
        const vec3 value = uintBitsToFloat(kForward ? tangentTexel(path).xyz : suffixTexel(path).xyz);
        const bool finite = !any(isnan(value)) && !any(isinf(value));
        if (!finite) atomicAdd(statistics[kDroppedPixel], 1);
        addSample(p, finite ? value : vec3(0), sample0 + (path - first));
    }
    film[pixel] = p;
    if (kDifference) {
        FilmPixel d = differenceFilm[pixel];
        for (uint path = first; path < end; ++path) {
            const vec3 value = uintBitsToFloat(suffixTexel(path).xyz) - uintBitsToFloat(tangentTexel(path).xyz);
            const bool finite = !any(isnan(value)) && !any(isinf(value));
            if (!finite) atomicAdd(statistics[kDroppedPixel], 1);
            addSample(d, finite ? value : vec3(0), sample0 + (path - first));
        }
        differenceFilm[pixel] = d;
    }
    if (!kLayers) return;
    LayerSample sums = layerFilm[pixel];
    for (uint path = first; path < end; ++path) {
        const LayerSample l = layers[path];
        sums.normal += l.normal;
        sums.depth += l.depth;
        sums.albedo += l.albedo;
        sums.hit += l.hit;
        sums.guided += l.guided;
        sums.dead += l.dead;
        sums.cell = l.cell;
        sums.lightShare += l.lightShare;
        sums.drawn += l.drawn;
    }
    layerFilm[pixel] = sums;
}
