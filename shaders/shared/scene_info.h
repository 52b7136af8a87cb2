// Scene-wide facts the kernels need beside the tables.
#ifndef CMPG_SHARED_SCENE_INFO
#define CMPG_SHARED_SCENE_INFO
#include "shared/light.h"
CMPG_SHARED_BEGIN

struct SceneInfo {
    EnvironmentInfo environment;
    uint lights; // entries of the light table
    uint lightCandidates; // as kFeatureLightCandidates, where that is 0
    uint secondMaterials, secondTexels; // where the second set of materials and values starts
    float environmentDistance; // any length beyond the scene
    vec3 emittersLow, emittersHigh; // box around the surfaces that emit; low > high: none does
};

CMPG_SHARED_END
#endif
