// What constants decide: branches of short-circuited conditions, functions that return what follows from constants, a loop that may never run, and
// arithmetic of constants. Writes for each input a number that tells which of them it met.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
layout(constant_id = 0) const bool kFirst = false;
layout(constant_id = 1) const bool kSecond = true;
layout(constant_id = 2) const uint kBits = 6;
layout(constant_id = 3) const float kScale = 0.5;
layout(push_constant, scalar) uniform Push { uint count; } push;
layout(binding = 0, scalar) readonly buffer Input { uint numbers[]; };
layout(binding = 1, scalar) writeonly buffer Output { uint result[]; };

const uint kShifted = kBits >> 1 & 3u;

bool either() {
    if (kFirst) return kSecond;
    return false;
}

uint grown(uint n) {
    precise float value = float(n) * kScale + 1.0;
    return uint(value);
}

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const uint n = numbers[i];
    uint met = 0;
    if (kFirst && n > 3) met += 1;
    if (kSecond || n == 2) met += 2;
    if (either() && (n & 1u) == 0) met += grown(n) << 8;
    const bool large = kShifted == 3u ? n > 5 : kFirst;
    if (large) met += 4;
    for (uint k = 0; k < kShifted; ++k) {
        if (kSecond && k == n) break;
        met += 16;
    }
    if (!kFirst && !kSecond) met += grown(n + 1) << 8;
    result[i] = met;
}
