// What the film keeps of a pixel, and what a sample says about its first hit.
#ifndef CMPG_SHARED_FILM
#define CMPG_SHARED_FILM
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// Samples of one pixel that one batch may hold: a loop over them must stay far from the 65 535 iterations after which some drivers stop.
CMPG_CONST kMaxPixelSamples = 16384;

// Sums over the samples of a pixel, in sample order (lib/film_sum.glsl): of the value, and in w of mean_rgb of (value / scale)^2.
struct FilmPixel {
    vec4 sum, compensation; // of the samples since the last full block: their sum is that of both
    vec4 total, rest; // of the blocks before, likewise
    float scale; // a power of two, at most the largest component so far; 0: all were 0
};

CMPG_CONST kLayerDepths = 4; // components of a vec4

// First-hit features of one path, and the guide's at its first vertices; of a pixel: their sums.
struct LayerSample {
    vec3 normal;
    float depth;
    vec3 albedo;
    float hit; // 1 when a surface was hit
    float guided, dead; // 1 when its direction was drawn from the guide; and led nowhere
    float cell; // of the guide; of a pixel: that of its last sample
    vec4 lightShare; // by depth: share of P in the mixture, where a direction was drawn with a guide that knew something
    vec4 drawn; // by depth: 1 where one was
};

CMPG_SHARED_END
#endif
