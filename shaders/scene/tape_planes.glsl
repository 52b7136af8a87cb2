// Where the words of a vertex's derivative record stand; the planes of absent features take no room (shaders/shared/tape.h).
#include "shared/tape.h"
const uint kPlaneSecond = 0; // alone, in difference mode: N, w, (E)
const uint kPlaneMaterial = 0;
const uint kPlaneUv0 = 1;
const uint kPlaneUv1 = 3;
const uint kPlaneThroughput = kPlaneUv1 + (kTexcoord1 ? 2u : 0u);
const uint kPlaneEmissionWeight = kPlaneThroughput + (kReverse ? kTapeThroughput : 0u);
const uint kPlaneLight = kPlaneEmissionWeight + (kDiffLight ? kTapeEmissionWeight : 0u); // material, uv0, radiance factor, (uv1)
const uint kPlaneDrawn = kPlaneLight + (kDiffLight ? kTapeLight + (kTexcoord1 ? 2u : 0u) : 0u); // dw_i by place
const uint kPlaneLit = kPlaneDrawn + kTapeDerivative * kDerivativeCount; // dN_i
