// Runs a loop of push.count iterations whose result cannot be foreseen by the compiler.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 8) in;
layout(binding = 0, scalar) buffer Output { uint iterations, state; } result;
layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    uint state = result.state, iterations = 0;
    for (uint i = 0; i < push.count; ++i) {
        state = state * 1664525u + 1013904223u;
        if (state == 0u) break; // never reached from the states the test starts with
        ++iterations;
    }
    if (gl_GlobalInvocationID.x == 0) {
        result.iterations = iterations;
        result.state = state;
    }
}
