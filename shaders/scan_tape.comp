// One bounce of the backward scan: suffix radiance from the children, then what the derivatives make of it.
//   X = E_{i+1} + R_{i+1};  R_i = N_i + w_i X;  T_i = dN_i + dw_i X + w_i (dE_{i+1} + T_{i+1})
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifndef CMPG_PORTABLE
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "scene/features.glsl"
#include "scene/buffers.glsl"
#include "lib/physics.glsl"
#include "lib/fixed_point.glsl"
#include "lib/dispatch.glsl"
#include "scene/slots.glsl"
#include "scene/tape_planes.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ScanPush push; };
layout(binding = kBindCounts, scalar) readonly buffer Counts { QueueCounts counts[]; };
layout(binding = kBindPaths, scalar) readonly buffer Paths { uvec2 paths[]; };
layout(binding = kBindVertices, scalar) buffer Vertices { Vertex vertices[]; };
layout(binding = kBindNextVertices, scalar) readonly buffer NextVertices { Vertex nextVertices[]; };
layout(binding = kBindVisibility, scalar) readonly buffer Visibility { uint visibility[]; };
layout(binding = kBindTape, scalar) readonly buffer Tape { uint tape[]; };
layout(binding = kBindTangents, scalar) writeonly buffer Tangents { vec3 tangents[]; };
layout(binding = kBindNextTangents, scalar) readonly buffer NextTangents { vec3 nextTangents[]; };
layout(binding = kBindAdjoint, scalar) readonly buffer Adjoints { vec3 adjoints[]; };
READ_FLOAT(directionAt, kBindDirection)
layout(binding = kBindStatistics, scalar) buffer StatisticsBlock { uint statistics[]; };
#include "scene/gradient_sums.glsl"
#include "scene/tape_read.glsl"

void main() {
    const uint slot = globalIndex();
    if (push.count == 0 || slot >= counts[push.bounce].rays) return;
    const Vertex v = vertices[slot];
    vec3 incident = vec3(0); // X
    vec3 incidentTangent = vec3(0); // dE_{i+1} + T_{i+1}
    if (v.child != kNone) {
        incident = nextVertices[v.child].suffix;
        if (kForward) incidentTangent = nextTangents[v.child];
    }
    const float visible = v.shadow != kNone ? float(visibility[v.shadow]) : 0.0;
    // A second slice of the gradients repeats the scan for its entries alone.
    if (push.firstEntry == 0) vertices[slot].suffix = v.suffix + visible * v.direct + v.weight * incident;
    if (!kDerivatives) return;

    const uint material = tape[kPlaneMaterial * push.count + slot];
    vec3 tangent = v.weight * incidentTangent;
    vec3 reach = vec3(1); // adjoint times throughput
    if (kReverse) {
        reach = adjoints[paths[v.path].x];
        if (push.bounce > 0) reach *= tapeGet3(slot, kPlaneThroughput);
    }
    const vec2 uv0 = tapeGet2(slot, kPlaneUv0);
    const vec2 uv1 = kTexcoord1 ? tapeGet2(slot, kPlaneUv1) : vec2(0);
    if (kDiffSurface && material != kNone && push.bounce + 1 < kMaxDepth)
        tangent += surfaceTerms(slot, material, uv0, uv1, incident, visible, reach);
    if (kDiffLight) {
        const float found = tapeGet(slot, kPlaneEmissionWeight);
        if (found != 0.0) tangent += emissionTerm(material, uv0, uv1, vec3(found), reach);
        if (visible != 0.0) {
            const vec3 factor = tapeGet3(slot, kPlaneLight + 3);
            const vec2 lightUv1 = kTexcoord1 ? tapeGet2(slot, kPlaneLight + 6) : vec2(0);
            if (any(notEqual(factor, vec3(0))))
                tangent += emissionTerm(tape[kPlaneLight * push.count + slot], tapeGet2(slot, kPlaneLight + 1), lightUv1, factor, reach);
        }
    }
    if (kForward) tangents[slot] = tangent;
}
