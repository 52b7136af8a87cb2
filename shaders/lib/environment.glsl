// Directions of a latitude-longitude map, in the map's own frame, and the cells light sampling divides it into.
//
// u = atan2(x, -z) / 2 pi mod 1, v = acos(y) / pi. Texel centres lie at u = (column + 0.5) / width, v = row / (height - 1). A cell
// is the rectangle between four neighbouring centres, where the map is bilinear: width x (height - 1) cells, the last column wraps.
#ifndef CMPG_LIB_ENVIRONMENT
#define CMPG_LIB_ENVIRONMENT
#include "lib/math.glsl"

vec2 environmentUv(vec3 d) {
    float u = atan(d.x, -d.z) * (0.5 * kInvPi);
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

// Steradians of a cell of this row. 2 sin sin instead of a difference of cosines: no cancellation in thin rows.
float environmentCellSolidAngle(uint row, uint width, uint height) {
    float step = kPi / float(height - 1u);
    float middle = (float(min(row, height - 2u - row)) + 0.5) * step; // both hemispheres are alike
    return 2.0 * kPi / float(width) * 2.0 * accurateSin(middle) * accurateSin(0.5 * step);
}

// A direction uniform in the solid angle of the cell.
vec3 sampleEnvironmentCell(uvec2 cell, uint width, uint height, vec2 u) {
    float step = kPi / float(height - 1u);
    float top = 0.5 * step * float(cell.y); // half polar angles
    float bottom = top + 0.5 * step;
    // 1 - cos = 2 sin^2 of half the angle: relative accuracy at both poles.
    float s2 = mix(square(accurateSin(top)), square(accurateSin(bottom)), u.y);
    float above = 0.5 * step * float(height - 1u - cell.y); // the same from the lower pole
    float c2 = mix(square(accurateSin(above)), square(accurateSin(above - 0.5 * step)), u.y);
    float turn = (float(cell.x) + 0.5 + u.x) / float(width);
    vec2 on = 2.0 * sqrt(s2 * c2) * unitCircle(turn > 1.0 ? turn - 1.0 : turn);
    return vec3(on.y, c2 - s2, -on.x);
}

#endif
