// The one place random numbers come from. The includer defines the bool constant kSobol.
#ifndef CMPG_LIB_SAMPLER
#define CMPG_LIB_SAMPLER
#include "lib/sobol.glsl"

// Set number `set` of the vertex `key` names, uniform in [0,1)^4. A caller that needs two numbers takes .x and .y, which are the
// best stratified pair; what it leaves unused costs nothing.
vec4 sampleSet(SampleKey key, uint set) {
    if (kSobol) return sobolSet(key.sampleIndex & kSampleBlockMask, setKey(key, set));
    return independentSet(key, set);
}

#endif
