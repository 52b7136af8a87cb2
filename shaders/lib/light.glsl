// Light sources: densities of points on emitters and the falloff of punctual lights (KHR_lights_punctual).
#ifndef CMPG_LIB_LIGHT
#define CMPG_LIB_LIGHT
#include "lib/math.glsl"

// Density per steradian, seen over this squared distance, of a point drawn with a density per area. cosine: between the emitter's
// normal and the way back; 0 from behind.
float areaToSolidAngle(float density, float distance2, float cosine) {
    return cosine > kMinCosine ? density * distance2 / cosine : 0.0;
}

// Inverse square with the extension's smooth cut at the range; range 0 = unlimited.
float distanceFalloff(float distance2, float range) {
    float window = 1.0;
    if (range > 0.0) window = clamp(1.0 - square(distance2 / (range * range)), 0.0, 1.0);
    return distance2 > 0.0 ? window / distance2 : 0.0;
}

// cosine: between the spot's axis and the direction from the light to the point.
float spotFalloff(float cosine, float innerCos, float outerCos) {
    float scale = 1.0 / max(innerCos - outerCos, 0.001);
    return square(clamp((cosine - outerCos) * scale, 0.0, 1.0));
}

// Of 0 to 180 degrees by their cosine.
float angleOf(float cosine) { return atan(sqrt(max(1.0 - cosine * cosine, 0.0)), cosine); }

// The same, falling with the angle, as Mitsuba's spots do.
float spotAngleFalloff(float cosine, float innerCos, float outerCos) {
    float outer = angleOf(outerCos);
    return clamp((outer - angleOf(cosine)) / max(outer - angleOf(innerCos), 1e-6), 0.0, 1.0);
}

#endif
