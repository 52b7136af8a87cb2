// Fresnel's equations for unpolarised light (Born and Wolf, "Principles of Optics", 1.5).
#ifndef CMPG_LIB_FRESNEL
#define CMPG_LIB_FRESNEL
#include "lib/math.glsl"

struct Boundary {
    float reflected;   // of the energy
    float transmitted; // the rest, with a relative accuracy of its own
    float cosine;      // of the refracted direction, > 0; 0 under total reflection
};

// A boundary seen at cosine c >= 0; eta: index of refraction behind it over that in front.
Boundary dielectricBoundary(float c, float eta) {
    Boundary b;
    b.reflected = 1.0;
    b.transmitted = 0.0;
    b.cosine = 0.0;
    float cos2 = 1.0 - (1.0 - c) * (1.0 + c) / (eta * eta);
    if (!(cos2 > 0.0)) return b;
    b.cosine = sqrt(cos2);
    float across = c + eta * b.cosine;
    float along = eta * c + b.cosine;
    float s = (c - eta * b.cosine) / across;
    float p = (eta * c - b.cosine) / along;
    b.reflected = 0.5 * (s * s + p * p);
    b.transmitted = 2.0 * eta * c * b.cosine * (1.0 / (across * across) + 1.0 / (along * along));
    return b;
}

// d transmitted / d c.
float transmittedDerivative(float c, float eta, Boundary b) {
    if (!(b.cosine > 0.0)) return 0.0;
    float across = c + eta * b.cosine;
    float along = eta * c + b.cosine;
    float s = (c - eta * b.cosine) / across;
    float p = (eta * c - b.cosine) / along;
    float change = 2.0 * eta * (b.cosine - c * c / (eta * eta * b.cosine));
    return -change * (s / (across * across) + p / (along * along));
}

// Both boundaries of a pane, with the light that goes to and fro between them: R + T^2 R / (1 - R^2) and the rest.
Boundary paneBoundary(float c, float eta) {
    Boundary b = dielectricBoundary(c, eta);
    float both = 1.0 + b.reflected;
    b.reflected = 2.0 * b.reflected / both;
    b.transmitted = b.transmitted / both;
    b.cosine = c;
    return b;
}

// What a conductor of complex index eta - i k reflects at cosine c, per channel.
vec3 conductorReflected(float c, vec3 eta, vec3 k) {
    float c2 = c * c;
    float s2 = (1.0 - c) * (1.0 + c);
    vec3 difference = eta * eta - k * k - vec3(s2);
    vec3 sum = max(sqrt(difference * difference + 4.0 * eta * eta * k * k), vec3(1e-12)); // a^2 + b^2; 0 where eta, k and s2 are
    vec3 a = sqrt(max(0.5 * (sum + difference), vec3(0.0)));
    vec3 across = sum + vec3(c2);
    vec3 twice = 2.0 * c * a;
    vec3 s = (across - twice) / (across + twice);
    vec3 along = c2 * sum + vec3(s2 * s2);
    vec3 p = s * (along - s2 * twice) / (along + s2 * twice);
    return 0.5 * (s + p);
}

#endif
