// The vertices of one class of surfaces: emission found, one light sample, one drawn direction; leaves the local factors on the tape.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "scene/features.glsl"
#include "scene/buffers.glsl"
#define CMPG_READ_RAYS
#define CMPG_READ_HITS
#define CMPG_READ_PREFIXES
#define CMPG_READ_COPIES
#define CMPG_READ_PATHS
#define CMPG_READ_SORTED
#include "scene/queues.glsl"
#include "shared/film.h"
#include "lib/physics.glsl"
#include "lib/dispatch.glsl"
#include "lib/box.glsl"
#include "scene/geometry.glsl"
#include "scene/slots.glsl"
#include "scene/materials.glsl"
#include "scene/alpha_mask.glsl"
#include "scene/environment.glsl"
#include "scene/lights.glsl"
#include "scene/light_choice.glsl"
#include "scene/tape_planes.glsl"
#define CMPG_GUIDE_DIRECTIONS
#include "scene/guide_lookup.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindNextRays, scalar) writeonly buffer NextRays { uvec4 nextRays[]; };
layout(binding = kBindShadowRays, scalar) writeonly buffer ShadowRays { uvec4 shadowRays[]; };
layout(binding = kBindVertices, scalar) writeonly buffer Vertices { uvec4 vertices[]; };
layout(binding = kBindTape, scalar) writeonly buffer Tape { uint tape[]; };
layout(binding = kBindNextPrefixes, scalar) writeonly buffer NextPrefixes { uvec4 nextPrefixes[]; };
layout(binding = kBindGuideVisits, scalar) writeonly buffer GuideVisits { GuideVisit visits[]; };
layout(binding = kBindLayers, scalar) writeonly buffer Layers { LayerSample layers[]; };
layout(binding = kBindStatistics, scalar) buffer StatisticsBlock { uint statistics[]; };
#include "scene/vertex.glsl"
#include "scene/tape_write.glsl"

// One atomic a subgroup; places are handed out in any order, results do not depend on it.
uint allocateRay(bool wanted) {
    const uvec4 votes = subgroupBallot(wanted);
    const uint taken = subgroupBallotBitCount(votes);
    uint first = 0;
    if (taken != 0 && subgroupElect()) {
        first = atomicAdd(counts[push.bounce + 1].rays, taken);
        GROW_GROUPS(counts[push.bounce + 1].rayGroups, first, taken, kTraceChunk)
        GROW_GROUPS(counts[push.bounce + 1].arrivalGroups, first, taken, kVertexGroup)
    }
    first = subgroupBroadcastFirst(first); // by all lanes: the elected one need not want a place
    return wanted ? first + subgroupBallotExclusiveBitCount(votes) : kNone;
}

uint allocateShadowRay(bool wanted) {
    const uvec4 votes = subgroupBallot(wanted);
    const uint taken = subgroupBallotBitCount(votes);
    uint first = 0;
    if (taken != 0 && subgroupElect()) {
        first = atomicAdd(counts[push.bounce].shadowRays, taken);
        GROW_GROUPS(counts[push.bounce].shadowGroups, first, taken, kTraceChunk)
    }
    first = subgroupBroadcastFirst(first); // by all lanes: the elected one need not want a place
    return wanted ? first + subgroupBallotExclusiveBitCount(votes) : kNone;
}

// What the guide did at this bounce.
void countGuided(GuidePoint g, bool guided, bool scatters) {
    const bool drawn = g.share > 0.0 && push.bounce + 1 < push.depth;
    const uint all = subgroupBallotBitCount(subgroupBallot(drawn)), fromGuide = subgroupBallotBitCount(subgroupBallot(guided));
    const uint dead = subgroupBallotBitCount(subgroupBallot(guided && !scatters));
    const uint light = subgroupAdd(drawn ? uint(float(kShareUnits) * min(g.parts.x, 1.0) + 0.5) : 0u);
    if (subgroupElect()) {
        atomicAdd(counts[push.bounce].drawn, all);
        atomicAdd(counts[push.bounce].guided, fromGuide);
        atomicAdd(counts[push.bounce].dead, dead);
        atomicAdd(counts[push.bounce].lightShare, light);
    }
}

// Russian roulette from the third vertex on: a path goes on with the probability of what the surface scatters of the light, and weighs as much more. The
// roulette of a guide that has learned what paths are worth (split_paths.comp) takes its place.
const uint kFirstRoulette = 2; // bounce
const float kLeastSurvival = 0.25; // derivatives live on black surfaces, too

// `scale`: by what refraction scaled the radiance, which is no loss.
float survival(vec3 weight, float scale) {
    if (push.bounce < kFirstRoulette) return 1.0;
    if (kRoulette && guide.reference > 0.0) return 1.0;
    const float largest = max(weight.x, max(weight.y, weight.z));
    return clamp(kDielectric ? largest / scale : largest, kLeastSurvival, 1.0);
}

// The light sample of a vertex: N_i, that of the second set of values, and derivatives. Returns whether its visibility matters.
bool sampleDirect(uint slot, SurfacePoint p, SurfaceMaterial sampling, SurfaceMaterial value, SurfaceMaterial second, bool differentiated, GuidePoint g, vec3 wo,
                  vec3 kept, vec4 u, OUT(vec3) direct, OUT(vec3) secondDirect, OUT(LightSample) light) {
    direct = vec3(0);
    secondDirect = vec3(0);
    const FewLights few = readFewLights(scene.lights);
    const LightChoice choice = chooseLightSample(scene, few, p.position, sampling.surface, sampling.normal, wo, u);
    light = sampleLight(scene, selectedLight(few, scene.lights, choice.u.x), p.position, choice.u);
    if (choice.weight == 0.0) light.density = 0.0;
    bool wanted = false;
    vec3 factor = vec3(0); // N_i / L_e
    BsdfDerivatives d;
    clear(d);
    vec3 radiance = vec3(0);
    if (light.density > 0.0) {
        const float weight = light.extended ? misWeight(light.density, mixtureDensity(g, sampling.surface, sampling.normal, wo, light.direction)) : 1.0;
        const float scale = choice.weight * weight / light.density;
        radiance = lightRadiance(scene, light, kFrozen ? scene.secondMaterials : 0, kFrozen ? scene.secondTexels : 0);
        if (kDiffSurface && differentiated)
            factor = scale * scatterDerivatives(p, value, value.normal, wo, light.direction, false, d);
        else
            factor = scale * scattered(p, value, value.normal, wo, light.direction, false);
        if (kAbsorbing) factor *= kept;
        factor = keepFinite(factor);
        direct = keepFinite(factor * radiance);
        wanted = any(notEqual(direct, vec3(0)));
        if (kDifference) {
            vec3 secondFactor = factor, secondRadiance = radiance;
            if (kSecondSurface) {
                secondFactor = scale * scattered(p, second, second.normal, wo, light.direction, false);
                if (kAbsorbing) secondFactor *= kept;
            }
            if (kSecondLight) secondRadiance = lightRadiance(scene, light, scene.secondMaterials, scene.secondTexels);
            secondDirect = keepFinite(secondFactor * secondRadiance);
            wanted = wanted || any(notEqual(secondDirect, vec3(0)));
        }
        if (kDiffSurface && differentiated) {
            scaleDerivatives(d, kAbsorbing ? scale * radiance * kept : scale * radiance);
            wanted = wanted || anyDerivative(d);
        }
        if (kDiffLight) wanted = wanted || any(notEqual(factor, vec3(0)));
    }
    if (kDiffSurface && differentiated) tapeDerivatives(slot, kPlaneLit, d);
    if (kDiffLight) tapeLight(slot, wanted && light.extended, light, factor);
    return wanted;
}

SampleKey vertexKey(Ray ray, Prefix prefix) {
    const uvec2 path = readPath(pathOf(ray));
    return SampleKey(streamKey(batch.seed.x, batch.seed.y, batch.step, batch.pass), batch.firstPixel + path.x, path.y, prefix.branch, push.bounce);
}

void main() {
    const uint index = globalIndex();
    if (push.count == 0 || index >= here.classes[kClass]) return;
    const uint slot = sortedVertex(kClass * push.count + index);
    Copy copy = Copy(slot, 0, 1.0, 1);
    if (kRoulette) copy = readCopy(slot);
    const Ray ray = readRay(copy.ray);
    const Hit hit = readHit(copy.ray);
    const Prefix prefix = loadPrefix(copy.ray, copy);
    if (kReverse) tapePut3(slot, kPlaneThroughput, prefix.throughput);
    SurfacePoint p = surfacePoint(hit.triangle, hit.barycentrics);
    if (kBlend) chooseBlended(p, sampleSet(vertexKey(ray, prefix), kSetBlend).x);
    const vec3 wo = -ray.direction;
    SurfaceMaterial sampling = surfaceMaterial(p, wo, 0, 0);
    SurfaceMaterial value = sampling;
    if (kFrozen) value = surfaceMaterial(p, wo, scene.secondMaterials, scene.secondTexels);
    SurfaceMaterial secondValue = sampling;
    if (kSecondSurface) readSlots(secondValue, p, wo, kSecondSlots, scene.secondMaterials, scene.secondTexels);
    SecondFactors second = SecondFactors(vec3(0), vec3(0), vec3(0));
    const bool differentiated = kDiffSurface && ((sampling.surface.asked & kScatteringSlots) != 0 ||
                                                 (kDiffWeight && (sampling.flags & kMaterialWeightDifferentiated) != 0));
    if (IS_DIELECTRIC(sampling.surface)) {
        sampling.normal = boundaryNormal(sampling.surface, sampling.normal, p.faceNormal, wo);
        if (kFrozen) value.normal = boundaryNormal(value.surface, value.normal, p.faceNormal, wo);
        else value.normal = sampling.normal;
        if (kSecondSurface) secondValue.normal = boundaryNormal(secondValue.surface, secondValue.normal, p.faceNormal, wo);
    }

    // Emission, one-sided.
    Vertex v = Vertex(vec3(0), kNone, vec3(0), kNone, vec3(0), pathOf(ray));
    float emissionWeight = 0.0;
    const float cosFace = dot(p.faceNormal, wo);
    if (kEmission && (sampling.flags & kMaterialEmissive) != 0 && cosFace > 0.0) {
        emissionWeight = 1.0;
        if (kTriangleLights && push.bounce > 0) emissionWeight = foundWeight(ray.pdf, areaToSolidAngle(lightDensity(hit.triangle), hit.t * hit.t, cosFace));
        const vec3 radiance = emittedRadiance(p.material, sampling.flags, p.uv0, p.uv1, kFrozen ? scene.secondMaterials : 0, kFrozen ? scene.secondTexels : 0);
        v.emission = keepFinite(emissionWeight * radiance);
        if (kSecondLight)
            second.emission = keepFinite(emissionWeight * emittedRadiance(p.material, sampling.flags, p.uv0, p.uv1, scene.secondMaterials, scene.secondTexels));
    }
    if (kDerivatives) {
        tapeSurface(slot, p.material, p.uv0, p.uv1);
        if (kDiffLight) tapePut(slot, kPlaneEmissionWeight, emissionWeight);
    }
    // Of the light that comes back through the interior of what was hit from within.
    vec3 kept = vec3(1);
    if (kAbsorbing && cosFace < 0.0) {
        const uint interior = (kBlend ? interiorMaterial(p) : p.material) * kMaterialTexels;
        const uvec4 m1 = materialTexel(interior + 1);
        if ((m1.w & kMaterialAbsorbs) != 0) kept = interiorTransmittance(uintBitsToFloat(uvec3(m1.xy, materialTexel(interior + 2).w)), hit.t);
    }
    const bool last = push.bounce + 1 >= push.depth;
    // Where no light counts yet, a path must at least be able to scatter once more.
    const bool lightCounts = kAllLight || differentiated || (ray.path & kLightCounts) != 0;
    const bool leads = lightCounts || push.bounce + 2 < push.depth;
    bool wantShadow = false, wantRay = false, scatters = false;
    LightSample light;
    vec3 wi = vec3(0, 0, 1);
    float pdf = 0.0;
    uint leaf = kNone;
    vec3 tangent = vec3(0); // A of the next vertex
    bool guided = false, single = false;
    const GuidePoint g = guidePoint(p.position, sampling.surface, prefix);
    if (!last) {
        const SampleKey key = vertexKey(ray, prefix);
        if (kLightSampling && scene.lights > 0)
            wantShadow = sampleDirect(slot, p, sampling, value, secondValue, differentiated, g, wo, kept, sampleSet(key, kSetLight), v.direct, second.direct, light) &&
                         lightCounts;
        else if (kDiffSurface && differentiated)
            tapeNoDerivatives(slot, kPlaneLit);
        if (!(kLightSampling && scene.lights > 0) && kDiffLight) tapeLight(slot, false, light, vec3(0));

        // The drawn direction.
        BsdfDerivatives d;
        clear(d);
        if (drawDirection(g, sampling.surface, sampling.normal, wo, sampleSet(key, kSetScatter), wi, pdf, leaf, guided, single)) {
            if (kDiffSurface && differentiated) {
                v.weight = scatterDerivatives(p, value, sampling.normal, wo, wi, single, d) / pdf;
                scaleDerivatives(d, vec3(1.0 / pdf));
            } else {
                v.weight = scattered(p, value, sampling.normal, wo, wi, single) / pdf;
            }
            v.weight = keepFinite(v.weight);
            // A black albedo ends no path whose derivative lives.
            if (kDifference) second.weight = kSecondSurface ? keepFinite(scattered(p, secondValue, sampling.normal, wo, wi, single) / pdf) : v.weight;
            wantRay = any(notEqual(v.weight, vec3(0))) || any(notEqual(second.weight, vec3(0))) || (kDiffSurface && differentiated && anyDerivative(d));
            scatters = wantRay;
            wantRay = wantRay && leads;
            // By the values that sampling goes by, as all decisions.
            float scale = 1.0;
            if (kDielectric) scale = radianceScale(sampling.surface, p.faceNormal, wo, wi);
            const float q = survival(kFrozen ? scattered(p, sampling, sampling.normal, wo, wi, single) / pdf : v.weight, scale);
            if (q < 1.0) {
                wantRay = wantRay && sampleSet(key, kSetRoulette).x < q;
                v.weight /= q;
                second.weight /= q;
                scaleDerivatives(d, vec3(1.0 / q));
            }
            if (kAbsorbing) {
                v.weight *= kept;
                second.weight *= kept;
                if (kDiffSurface && differentiated) scaleDerivatives(d, kept);
            }
        }
        if (kPrefixTangent) {
            tangent = prefix.tangent * v.weight;
            if (kDiffSurface && differentiated) tangent += prefix.throughput * derivativeNorm(d, kSigned ? batch.sign : 0);
        }
        if (kDiffSurface && differentiated) tapeDerivatives(slot, kPlaneDrawn, d);
    }

    if (kDifference) tapeSecond(slot, second);
    if (kGuided) countGuided(g, guided, scatters);
    if (kLayers && push.bounce == 0)
        layers[pathOf(ray)] = LayerSample(sampling.normal, hit.t, sampling.surface.baseColor, 1.0, float(guided), float(guided && !scatters), float(g.cell), vec4(0), vec4(0));
    if (kLayers && kGuided && push.bounce < kLayerDepths && !last && g.share > 0.0) {
        layers[pathOf(ray)].lightShare[push.bounce] = min(g.parts.x, 1.0);
        layers[pathOf(ray)].drawn[push.bounce] = 1.0;
    }
    if (kRecord) visits[slot] = last ? GuideVisit(kNone, kNone) : GuideVisit(g.guidable ? leaf : kNone, g.cell);
    // A path's last ray looks for emission alone.
    if (!kEnvironment && push.bounce + 2 == push.depth) wantRay = wantRay && crossesBox(p.position, wi, scene.emittersLow, scene.emittersHigh);
    v.child = allocateRay(wantRay);
    if (wantRay) {
        const Ray next = Ray(offsetRayOrigin(p.position, p.faceNormal, wi, p.magnitude), pathOf(ray) | (lightCounts ? kLightCounts : 0), wi, kSmoothLobes && single ? kSingleDirection : pdf);
        WRITE_RAY(nextRays, v.child, next)
        const Prefix collected = Prefix(prefix.throughput * v.weight, prefix.branch, tangent, prefix.copies);
        if (kDerivatives && kPrefix) WRITE_PREFIX(nextPrefixes, v.child, collected)
    }
    if (kLightSampling) v.shadow = allocateShadowRay(wantShadow);
    if (wantShadow) {
        // Between the two offset points: seen from the point itself, the way from its offset one would end behind a grazing emitter.
        const vec3 origin = offsetRayOrigin(p.position, p.faceNormal, light.direction, p.magnitude);
        const vec3 way = light.target - origin;
        const float reach = light.hasTarget ? length(way) : light.distance;
        const ShadowRay shadow = ShadowRay(origin, reach, light.hasTarget ? way / max(reach, 1e-30) : light.direction, slot);
        WRITE_SHADOW_RAY(shadowRays, v.shadow, shadow)
    }
    countDropped();
    WRITE_VERTEX(vertices, slot, v)
}
