// The derivative half of the tape: planes of `capacity` words, so that neighbouring vertices' words are neighbours.
// Which planes exist follows from the features; the host sizes the pool with tapePlanes(), the kernels address it with the same sums.
#ifndef CMPG_SHARED_TAPE
#define CMPG_SHARED_TAPE
#include "shared/features.h"
#include "shared/material.h"
CMPG_SHARED_BEGIN

CMPG_CONST kTapeSurface = 3; // material or kNone for the environment, u0, v0: the first planes
CMPG_CONST kTapeTexcoord1 = 2; // u1, v1, behind them
CMPG_CONST kTapeThroughput = 3; // b_i, reverse mode only
CMPG_CONST kTapeEmissionWeight = 1; // MIS weight of the emission found here, 0 if none is seen
CMPG_CONST kTapeDerivative = 3; // of dw_i, and as many of dN_i behind those: for each place of lib/derivative_places.glsl
CMPG_CONST kTapeLight = 6; // material of the light, its u0, v0 and dN_i / dL_e (RGB)
CMPG_CONST kTapeSecond = 6; // N_i, w_i under the second set of values, difference mode only
CMPG_CONST kTapeSecondLight = 3; // E_i likewise, behind them, where light is differentiated

// Statistics counters, one uint each.
CMPG_CONST kDroppedRadiance = 0; // non-finite light of a vertex
CMPG_CONST kDroppedDerivative = 1; // non-finite derivative of a vertex
CMPG_CONST kSaturatedGradient = 2; // contribution or sum too large for the fixed-point sum
CMPG_CONST kSaturatedRecord = 3; // record of the guide too large for its fixed-point sum
CMPG_CONST kDroppedPixel = 4; // non-finite sample of a pixel
CMPG_CONST kLostGradient = 5; // not a count: 1 once a contribution was rounded to nothing
CMPG_CONST kStatisticsCount = 6;

CMPG_SHARED_END

#ifdef __cplusplus
namespace cmpg::gpu {
// Words a vertex takes in the tape of a pass.
inline uint tapePlanes(uint mode, uint differentiated, bool texcoord1) {
    if (mode == kModeRender)
        return 0;
    const auto has = [&](uint slot) { return (differentiated >> slot & 1u) != 0; };
    const bool light = has(kSlotEmission) || has(kSlotRadiance);
    if (mode == kModeDifference)
        return kTapeSecond + (light ? kTapeSecondLight : 0);
    const uint texcoords = texcoord1 ? kTapeTexcoord1 : 0;
    uint planes = kTapeSurface + texcoords + (mode == kModeReverse ? kTapeThroughput : 0);
    for (uint slot = 0; slot < kMaterialSlots; ++slot)
        if (has(slot) && (kScatteringSlots >> slot & 1u))
            planes += 2 * kTapeDerivative * (slot == kSlotNormal || slot == kSlotSheenColor ? 3 : 1);
    if (light)
        planes += kTapeEmissionWeight + kTapeLight + texcoords;
    return planes;
}
}
#endif
#endif
