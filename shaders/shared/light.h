// Lights as the kernels sample them. One entry each: emissive triangles, punctual lights, then the environment.
#ifndef CMPG_SHARED_LIGHT
#define CMPG_SHARED_LIGHT
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kLightTriangle = 0;
CMPG_CONST kLightPoint = 1;
CMPG_CONST kLightSpot = 2;
CMPG_CONST kLightDirectional = 3;
CMPG_CONST kLightEnvironment = 4;
CMPG_CONST kLightSpotByAngle = 5; // falls off with the angle

struct GpuLight {
    uint kind; // emissive triangles: and above kLightKindBits their material, as the material table counts
    uint triangle; // in BVH order; emissive triangles only
    float probability; // of being selected; emissive triangles: per unit area
    float cumulative; // sum of the probabilities up to and including this one; exactly 1 for the last
    vec3 position; // emissive triangles: the first corner
    float range; // 0 = unlimited. Directional lights and the environment: 1 / area of a disc as wide as the scene. Emissive triangles: normal.x
    vec3 direction; // the light travels along it. Emissive triangles: from the first to the second corner
    float innerCos; // spots. Emissive triangles: normal.y
    vec3 intensity; // emissive triangles: from the first to the third corner
    float outerCos; // spots. Emissive triangles: normal.z
};
CMPG_CONST kLightTexels = 4;
CMPG_CONST kLightKindBits = 3;

// The environment map for sampling: cells between neighbouring texel centres, W x (H - 1) of them.
struct EnvironmentInfo {
    uint width, height; // of the map; 0 without environment
    uint texels; // first value among the parameter values, in vec4 texels
    uint gradient; // first gradient entry, kNone when not differentiated
    float cosRotation, sinRotation;
    float probability; // of being selected among the lights
    float compensation; // sampling takes so much off the sum of a texel's channels: LightDistribution
};

CMPG_SHARED_END
#endif
