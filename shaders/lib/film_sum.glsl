// The sum over the samples of a pixel, exact to 1e-7 of itself for as many samples as 32 bits count, and of any radiance.
//
// Blocks of samples are summed with compensation (Neumaier) and added to a sum in two floats. Blocks, because a compensation that
// collects more than 2^24 equal losses loses them itself. They begin at fixed samples, so batches change nothing.
#ifndef CMPG_LIB_FILM_SUM
#define CMPG_LIB_FILM_SUM
#include "lib/dual.glsl"
#include "shared/film.h"

const uint kFilmBlock = 4096u; // a power of two

void addCompensated(INOUT(vec4) sum, INOUT(vec4) compensation, vec4 value) {
    PRECISE vec4 s = sum + value;
    PRECISE vec4 lost = mix((value - s) + sum, (sum - s) + value, greaterThanEqual(abs(sum), abs(value)));
    compensation = compensation + lost;
    sum = s;
}

// total + rest += sum + compensation.
void foldBlock(INOUT(FilmPixel) p) {
    PRECISE vec4 s = p.total + p.sum;
    PRECISE vec4 fromSum = s - p.total;
    PRECISE vec4 lost = (p.total - (s - fromSum)) + (p.sum - fromSum);
    PRECISE vec4 rest = (p.rest + p.compensation) + lost;
    PRECISE vec4 total = s + rest;
    PRECISE vec4 left = rest - (total - s);
    p.total = total;
    p.rest = left;
    p.sum = vec4(0.0);
    p.compensation = vec4(0.0);
}

// Squares neither overflow nor vanish: they are of the value over the largest seen, rounded to a power of two so that changing it
// loses nothing.
void raiseScale(INOUT(FilmPixel) p, float largest) {
    float scale = uintBitsToFloat(floatBitsToUint(largest) & 0x7f800000u);
    scale = max(scale, 1.1754944e-38);
    float shrink = p.scale / scale;
    vec4 factor = vec4(1.0, 1.0, 1.0, shrink * shrink);
    p.sum = p.sum * factor;
    p.compensation = p.compensation * factor;
    p.total = p.total * factor;
    p.rest = p.rest * factor;
    p.scale = scale;
}

// `value` is finite; index: of the sample in its pixel.
void addSample(INOUT(FilmPixel) p, vec3 value, uint index) {
    float largest = max(abs(value.x), max(abs(value.y), abs(value.z)));
    if (largest >= 2.0 * p.scale && largest > 0.0) raiseScale(p, largest);
    vec3 unit = value / max(p.scale, 1.1754944e-38);
    addCompensated(p.sum, p.compensation, vec4(value.x, value.y, value.z, dot(unit, unit) / 3.0));
    if ((index & (kFilmBlock - 1u)) == kFilmBlock - 1u) foldBlock(p);
}

#endif
