// Directions of a latitude-longitude map, in the map's own frame, and the cells light sampling divides it into.
//
// u = atan2(x, -z) / 2 pi mod 1, v = acos(y) / pi. Texel centres lie at u = (column + 0.5) / width, v = row / (height - 1). A cell
// is the rectangle between four neighbouring centres, where the map is bilinear: width x (height - 1) cells, the last column wraps.
#ifndef CMPG_LIB_ENVIRONMENT
#define CMPG_LIB_ENVIRONMENT
#include "lib/math.glsl"
#include "lib/warp.glsl"

vec2 environmentUv(vec3 d) {
    float u = atan(d.x, d.z == 0.0 ? 1e-30 : -d.z) * (0.5 * kInvPi); // GLSL has no atan(0, 0)
    return vec2(u < 0.0 ? u + 1.0 : u, atan(sqrt(d.x * d.x + d.z * d.z), d.y) * kInvPi); // accurate at the poles, unlike acos
}

vec3 environmentDirection(vec2 uv) {
    float theta = kPi * uv.y;
    vec2 on = sin(theta) * unitCircle(uv.x);
    return vec3(on.y, cos(theta), -on.x);
}

// Rotation about +y by the angle with this cosine and sine: world = R_y(angle) * environment. The inverse has the opposite sine.
vec3 rotateY(vec3 d, float c, float s) { return vec3(c * d.x + s * d.z, d.y, c * d.z - s * d.x); }

// (column, row) of the cell that contains uv.
uvec2 environmentCell(vec2 uv, uint width, uint height) {
    float x = uv.x * float(width) - 0.5;
    uint column = x < 0.0 ? width - 1u : min(uint(x), width - 1u);
    return uvec2(column, min(uint(clamp(uv.y, 0.0, 1.0) * float(height - 1u)), height - 2u));
}

// The direction at `across` of the map's width, `down` below the upper edge of a row of cells, in rows, and the sine of its polar angle; accurate at both
// poles.
vec3 environmentPoint(float across, uint row, float down, uint height, OUT(float) sinTheta) {
    float above = (float(row) + down) / float(height - 1u), below = (float(height - 1u - row) - down) / float(height - 1u);
    sinTheta = accurateSin(kPi * clamp(min(above, below), 0.0, 0.5));
    vec2 on = sinTheta * unitCircle(across);
    return vec3(on.y, accurateSin(0.5 * kPi * (below - above)), -on.x);
}

// What a cell is sampled in proportion to, with a mean of 1: the radiance at its corners, bilinear between them, and a tenth of the mean everywhere, since
// a dark texel may be differentiated. Corners: left and right above, left and right below.
vec4 environmentCellCorners(vec4 radiance) {
    float mean = dot(radiance, vec4(0.25));
    return mean > 1e-37 ? radiance * (0.9 / mean) + vec4(0.1) : vec4(1);
}

// A point of the unit square with density in proportion to the corners.
vec2 sampleEnvironmentCell(vec4 corners, vec2 u) {
    float y = sampleLinear(u.y, corners.x + corners.y, corners.z + corners.w);
    return vec2(sampleLinear(u.x, mix(corners.x, corners.z, y), mix(corners.y, corners.w, y)), y);
}

// Density per steradian of a point of a cell that is selected with this probability.
float environmentCellDensity(vec4 corners, vec2 inside, float probability, float sinTheta, uint width, uint height) {
    float density = mix(mix(corners.x, corners.y, inside.x), mix(corners.z, corners.w, inside.x), inside.y);
    return probability * density * float(width) * float(height - 1u) / (2.0 * kPi * kPi * max(sinTheta, 1e-9));
}

#endif
