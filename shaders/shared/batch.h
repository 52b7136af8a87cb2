// One batch: a run of consecutive samples in pixel order, small enough for the pools.
#ifndef CMPG_SHARED_BATCH
#define CMPG_SHARED_BATCH
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

struct Batch {
    uvec2 seed; // low, high word
    uint step;
    uint pass;

    uint firstPixel; // row-major index in the image
    uint firstSample; // of the pass, within that pixel, that the batch begins with
    uint pixels; // pixels the batch touches; the last may continue in the next batch
    uint paths;
    int sign; // positivization: +1 or -1 keeps derivative terms of that sign; 0 keeps all
    uint allLight; // 0: a derivative pass may leave out light that is a factor of no derivative

    uint width, height;
    // Gradient sums are integers in units of 2^-k, x y = 2^k (two factors, since 2^k may exceed what a float holds).
    vec2 surfaceScale; // of slots that scatter
    vec2 normalScale; // of normals: their derivatives grow as the stored vectors get shorter
    vec2 emissionScale; // of slots that emit

    // A ray through image-plane point (x, y) in [-1,1]^2, y up: origin + (x right + y up) with direction `forward` when orthographic,
    // else from origin along x right + y up + forward.
    uint orthographic;
    vec3 cameraOrigin, cameraRight, cameraUp, cameraForward;

    // The reconstruction filter; read only where some camera has another than the box.
    uint filterKind;
    float filterRadius, filterDeviation; // in pixels
};
CMPG_CONST kFilterBox = 0; // the square of the pixel
CMPG_CONST kFilterTent = 1;
CMPG_CONST kFilterGaussian = 2;

CMPG_SHARED_END
#endif
