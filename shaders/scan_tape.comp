// One bounce of the backward scan: suffix radiance from the children, then what the derivatives make of it.
//   X = E_{i+1} + R_{i+1};  R_i = N_i + w_i X;  T_i = dN_i + dw_i X + w_i (dE_{i+1} + T_{i+1})
// In difference mode the second radiance follows the first recursion, with the second set of values.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifndef CMPG_PORTABLE
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "scene/features.glsl"
#define CMPG_READ_VERTICES
#define CMPG_READ_PATHS
#define CMPG_READ_ADJOINTS
#define CMPG_READ_SORTED
#include "scene/queues.glsl"
#include "shared/scene_info.h"
#include "shared/batch.h"
#include "scene/material_tables.glsl"
layout(binding = kBindScene, scalar) uniform SceneBlock { SceneInfo scene; };
layout(binding = kBindBatch, scalar) uniform BatchBlock { Batch batch; };
#include "lib/physics.glsl"
#include "lib/fixed_point.glsl"
#include "lib/dispatch.glsl"
#include "scene/slots.glsl"
#include "scene/tape_planes.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { ScanPush push; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindCountsFirst, scalar) uniform First { QueueCounts firstCounts; };
layout(binding = kBindSuffixes, scalar) writeonly buffer Suffixes { vec4 suffixes[]; };
QUEUE_UVEC4(nextSuffix, kBindNextSuffixes)
QUEUE_UINT(visibility, kBindVisibility)
QUEUE_UINT(tapeWord, kBindTape)
layout(binding = kBindTangents, scalar) writeonly buffer Tangents { vec4 tangents[]; };
QUEUE_UVEC4(nextTangent, kBindNextTangents)
READ_FLOAT(directionAt, kBindDirection)
layout(binding = kBindStatistics, scalar) buffer StatisticsBlock { uint statistics[]; };
QUEUE_UINT(nextArrivalWord, kBindNextArrivals)
layout(binding = kBindDerivatives, scalar) writeonly buffer Derivatives { DerivativeParts derivatives[]; };
QUEUE_UINT(nextDerivativeWord, kBindNextDerivatives)
layout(binding = kBindMoments, scalar) writeonly buffer Moments { VertexMoment moments[]; };
QUEUE_UINT(nextMomentWord, kBindNextMoments)
#include "scene/integer_sums.glsl"
#include "scene/gradient_sums.glsl"
#include "scene/guide_records.glsl"
#include "scene/tape_read.glsl"

// What the vertices a ray led to pass back.
struct Found {
    vec3 incident; // X = E_{i+1} + R_{i+1}
    vec3 tangent; // dE_{i+1} + T_{i+1} along the direction; difference mode: X of the second set of values
    DerivativeParts parts; // the same as sums of absolute terms
    float norm; // of the contributions made there and further along
};

void addFound(INOUT(Found) found, uint vertex, float weight, INOUT(vec3) own) {
    found.incident += weight * uintBitsToFloat(nextSuffix(vertex).xyz);
    if (kForward || kDifference) found.tangent += weight * uintBitsToFloat(nextTangent(vertex).xyz);
    if (kRecord && kDerivatives) {
        const DerivativeParts parts = READ_PARTS(nextDerivativeWord, vertex);
        found.parts.plus += weight * parts.plus;
        found.parts.minus += weight * parts.minus;
    }
    if (kMeasure && push.firstEntry == 0) {
        const VertexMoment moment = READ_MOMENT(nextMomentWord, vertex);
        own += moment.own; // copies stand at one point and add to the same entries
        found.norm = rootSum(found.norm, moment.below);
    }
}

Found gatherFound(uint child) {
    Found found = Found(vec3(0), vec3(0), DerivativeParts(vec3(0), vec3(0)), 0.0);
    if (child == kNone) return found;
    vec3 own = vec3(0);
    if (kRoulette) {
        const Arrival arrival = READ_ARRIVAL(nextArrivalWord, child);
        for (uint i = 0; i < arrival.count; ++i) addFound(found, arrival.first + i, arrival.weight, own);
    } else {
        addFound(found, child, 1.0, own);
    }
    found.norm = rootSum(found.norm, safeLength(own));
    return found;
}

// The record of a drawn direction; vertices at the depth limit drew none.
void leaveRecord(uint slot, vec3 scattered, vec3 reflected, Terms terms) {
    if (push.firstEntry != 0 || push.keepRecords == 0) return;
    const GuideVisit visit = GuideVisit(visitWord(2 * slot), visitWord(2 * slot + 1));
    if (visit.cell == kNone) return;
    const bool directed = visit.leaf != kNone;
    if (directed) ADD_RECORD(leafSums[visit.leaf].primal, scattered, guide.primalScale)
    ADD_RECORD(cellSums[visit.cell].reflected, reflected, guide.primalScale)
    if (kDerivatives) {
        if (directed) {
            ADD_RECORD(leafSums[visit.leaf].plus, terms.drawn.plus, guide.derivativeScale)
            ADD_RECORD(leafSums[visit.leaf].minus, terms.drawn.minus, guide.derivativeScale)
        }
        const vec3 all = terms.drawn.plus + terms.drawn.minus + terms.lit.plus + terms.lit.minus;
        ADD_RECORD(cellSums[visit.cell].derivative, all, guide.derivativeScale)
    }
    atomicAdd(cellSums[visit.cell].count, 1);
}

void main() {
    const uint index = globalIndex();
    const bool all = !kDerivatives || push.shadingClass == kVertexClasses;
    if (push.count == 0 || index >= (all ? (kRoulette ? here.vertices : here.rays) : here.classes[push.shadingClass])) return;
    const uint slot = all ? index : sortedVertex(push.shadingClass * push.count + index);
    if (kRoulette && firstCounts.overflow != 0) return; // the batch is void
    const Vertex v = readVertex(slot);
    const Found found = gatherFound(v.child);
    float visible = 0.0;
    if (kLightSampling && v.shadow != kNone) visible = float(visibility(v.shadow));
    // Further slices of the gradients repeat the scan for their entries alone.
    const vec3 scattered = v.weight * found.incident;
    const vec3 reflected = visible * v.direct + scattered; // R
    if (push.suffixes != 0) suffixes[slot] = vec4(v.emission + reflected, 0);
    if (kDifference)
        tangents[slot] = vec4((kSecondLight ? tapeGet3(slot, kPlaneSecond + kTapeSecond) : v.emission) + visible * tapeGet3(slot, kPlaneSecond) +
                                  tapeGet3(slot, kPlaneSecond + 3) * found.tangent, 0);
    if (!kDerivatives) {
        if (kRecord) leaveRecord(slot, scattered, reflected, noTerms());
        return;
    }

    const uint material = tapeWord(kPlaneMaterial * push.count + slot);
    vec3 reach = vec3(1); // adjoint times throughput
    if (kReverse) reach = readAdjoint(readPath(v.path).x) * tapeGet3(slot, kPlaneThroughput);
    Terms terms = noTerms();
    terms.drawn.plus = v.weight * found.parts.plus;
    terms.drawn.minus = v.weight * found.parts.minus;
    vec3 tangent = v.weight * found.tangent;
    const vec2 uv0 = tapeGet2(slot, kPlaneUv0);
    const vec2 uv1 = kTexcoord1 ? tapeGet2(slot, kPlaneUv1) : vec2(0);
    if (kDiffSurface && material != kNone && push.bounce + 1 < push.depth)
        tangent += surfaceTerms(slot, material, uv0, uv1, found.incident, visible, reach, terms);
    if (kDiffLight) {
        const float seen = tapeGet(slot, kPlaneEmissionWeight);
        if (seen != 0.0) tangent += emissionTerm(material, uv0, uv1, vec3(seen), reach, terms.emitted, terms.own);
        if (visible != 0.0) {
            const vec3 factor = tapeGet3(slot, kPlaneLight + 3);
            const vec2 lightUv1 = kTexcoord1 ? tapeGet2(slot, kPlaneLight + 6) : vec2(0);
            if (any(notEqual(factor, vec3(0))))
                tangent += emissionTerm(tapeWord(kPlaneLight * push.count + slot), tapeGet2(slot, kPlaneLight + 1), lightUv1, factor, reach, terms.lit, terms.own);
        }
    }
    if (kForward) tangents[slot] = vec4(tangent, 0);
    if (push.firstEntry != 0) return;
    if (kMeasure) moments[slot] = VertexMoment(terms.own.sum, found.norm, terms.own.entry);
    if (kRecord) {
        leaveRecord(slot, scattered, reflected, terms);
        derivatives[slot] = DerivativeParts(terms.drawn.plus + terms.lit.plus + terms.emitted.plus, terms.drawn.minus + terms.lit.minus + terms.emitted.minus);
    }
}
