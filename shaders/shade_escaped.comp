// Vertices of rays that left the scene: the environment's radiance, if there is one.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "scene/features.glsl"
#include "scene/buffers.glsl"
#define CMPG_READ_RAYS
#define CMPG_READ_PREFIXES
#define CMPG_READ_COPIES
#define CMPG_READ_SORTED
#include "scene/queues.glsl"
#include "shared/film.h"
#include "lib/physics.glsl"
#include "lib/dispatch.glsl"
#include "scene/environment.glsl"
#include "scene/tape_planes.glsl"
#include "shared/guide.h"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindVertices, scalar) writeonly buffer Vertices { uvec4 vertices[]; };
layout(binding = kBindTape, scalar) writeonly buffer Tape { uint tape[]; };
layout(binding = kBindGuideVisits, scalar) writeonly buffer GuideVisits { GuideVisit visits[]; };
layout(binding = kBindLayers, scalar) writeonly buffer Layers { LayerSample layers[]; };
layout(binding = kBindStatistics, scalar) buffer StatisticsBlock { uint statistics[]; };
#include "scene/vertex.glsl"

void main() {
    const uint index = globalIndex();
    if (push.count == 0 || index >= here.classes[kClassEscaped]) return;
    const uint slot = sortedVertex(kClassEscaped * push.count + index);
    Copy copy = Copy(slot, 0, 1.0, 1);
    if (kRoulette) copy = readCopy(slot);
    const Ray ray = readRay(copy.ray);
    if (kReverse) tapePut3(slot, kPlaneThroughput, loadPrefix(copy.ray, copy).throughput);
    if (kRecord) visits[slot] = GuideVisit(kNone, kNone);
    Vertex v = Vertex(vec3(0), kNone, vec3(0), kNone, vec3(0), pathOf(ray));
    vec2 uv = vec2(0);
    float weight = 0.0;
    SecondFactors second = SecondFactors(vec3(0), vec3(0), vec3(0));
    if (kEnvironment && scene.environment.width > 0) {
        const vec3 local = toEnvironment(scene.environment, ray.direction);
        uv = environmentUv(local);
        weight = 1.0;
        if (kEnvironmentLight && push.bounce > 0) weight = foundWeight(ray.pdf, environmentDensity(scene.environment, local, uv));
        v.emission = keepFinite(weight * environmentRadiance(scene.environment, uv, kFrozen ? scene.secondTexels : 0));
        if (kSecondLight) second.emission = keepFinite(weight * environmentRadiance(scene.environment, uv, scene.secondTexels));
    }
    if (kDifference) tapeSecond(slot, second);
    if (kDerivatives) {
        tapeSurface(slot, kNone, uv, vec2(0));
        if (kDiffLight) tapePut(slot, kPlaneEmissionWeight, weight);
    }
    countDropped();
    WRITE_VERTEX(vertices, slot, v)
    if (kLayers && push.bounce == 0) layers[pathOf(ray)] = LayerSample(vec3(0), 0.0, vec3(0), 0.0, 0.0, 0.0, 0.0, vec4(0), vec4(0));
}
