// Light sampling: one light by its selection probability, one point or direction on it.
// Expects lightTexel() and what geometry.glsl, materials.glsl, alpha_mask.glsl and environment.glsl expect.

// How far before a lamp without extent a shadow ray ends, in units of the largest coordinate: several times the rounding of positions, and of the test itself
// where the ray grazes the surface that the lamp sits on.
const float kLampGap = 1e-5;

struct LightSample {
    vec3 direction; // unit, towards the light
    float distance; // infinite in effect where there is no target
    bool hasTarget;
    vec3 target; // where its shadow ray ends: just before the emitter
    vec3 radiance; // arriving unoccluded
    float density; // per solid angle, or the selection probability of a light without extent
    bool extended; // a drawn direction could have found it as well
    uint material; // for the derivative of its emission; kNone: environment or punctual
    vec2 uv0, uv1; // where its emission is read; environment: map coordinates
};

// The texels of a GpuLight.
struct LightRecord {
    uvec4 head;
    vec4 where, along, extent;
};

LightRecord readLight(uint light) {
    const uint at = light * kLightTexels;
    return LightRecord(lightTexel(at), uintBitsToFloat(lightTexel(at + 1)), uintBitsToFloat(lightTexel(at + 2)), uintBitsToFloat(lightTexel(at + 3)));
}

uint lightKind(LightRecord light) { return light.head.x & ((1u << kLightKindBits) - 1u); }

// The lights of a scene that has kFewLights at most; the last of the table stands for those beyond it.
struct FewLights {
    LightRecord first, second, third, fourth;
};

FewLights readFewLights(uint count) {
    FewLights few;
    if (kFewLights > 0) {
        few.first = readLight(0);
        few.second = readLight(min(1, count - 1));
    }
    if (kFewLights > 2) {
        few.third = readLight(min(2, count - 1));
        few.fourth = readLight(count - 1);
    }
    return few;
}

LightRecord lightBefore(float u, LightRecord light, LightRecord otherwise) {
    const bool before = u < uintBitsToFloat(light.head.w);
    return LightRecord(mix(otherwise.head, light.head, bvec4(before)), mix(otherwise.where, light.where, bvec4(before)),
                       mix(otherwise.along, light.along, bvec4(before)), mix(otherwise.extent, light.extent, bvec4(before)));
}

uint selectLight(uint count, float u) {
    uint low = 0, high = count - 1;
    for (uint i = 0; i < 32 && low < high; ++i) {
        const uint middle = (low + high) / 2;
        if (u < uintBitsToFloat(lightTexel(middle * kLightTexels).w)) high = middle;
        else low = middle + 1;
    }
    return low;
}

LightRecord selectedLight(FewLights few, uint count, float u) {
    if (kFewLights == 0) return readLight(selectLight(count, u));
    LightRecord light = few.second;
    if (kFewLights > 2) light = lightBefore(u, few.second, lightBefore(u, few.third, few.fourth));
    return lightBefore(u, few.first, light);
}

// density = 0 when there is nothing to gain from this light at `position`.
LightSample sampleLight(SceneInfo scene, LightRecord light, vec3 position, vec3 u) {
    LightSample s;
    s.direction = vec3(0, 0, 1);
    s.distance = 0.0;
    s.hasTarget = false;
    s.target = vec3(0);
    s.radiance = vec3(0);
    s.density = 0.0;
    s.extended = true;
    s.material = kNone;
    s.uv0 = vec2(0);
    s.uv1 = vec2(0);
    const uint kind = lightKind(light);
    const float probability = uintBitsToFloat(light.head.z);
    const vec4 where = light.where, along = light.along, extent = light.extent;
    if (kTriangleLights && kind == kLightTriangle) {
        const vec2 b = sampleTriangle(u.yz);
        if (kTexturedEmission) {
            const SurfacePoint p = surfacePoint(light.head.y, b);
            s.uv0 = p.uv0;
            s.uv1 = p.uv1;
        }
        const vec3 normal = vec3(where.w, along.w, extent.w);
        const vec3 point = where.xyz + b.x * along.xyz + b.y * extent.xyz;
        const vec3 offset = point - position;
        const float distance2 = dot(offset, offset);
        s.distance = sqrt(distance2);
        s.direction = offset / max(s.distance, 1e-30);
        const float cosLight = -dot(normal, s.direction);
        s.hasTarget = true;
        const float magnitude = max(largestCoordinate(where.xyz), max(largestCoordinate(where.xyz + along.xyz), largestCoordinate(where.xyz + extent.xyz)));
        s.target = offsetRayOrigin(point, normal, -s.direction, magnitude);
        s.material = light.head.x >> kLightKindBits;
        s.density = areaToSolidAngle(probability, distance2, cosLight);
        if (kAlphaMask && isCutOut(light.head.y, b, position, s.direction)) s.density = 0.0; // a hole emits nothing
    } else if (kEnvironmentLight && kind == kLightEnvironment) {
        s.direction = sampleEnvironment(scene.environment, u.yz, s.uv0, s.density);
        s.distance = scene.environmentDistance;
    } else if (kPunctualLights) {
        s.extended = false;
        s.density = probability;
        if (kind == kLightDirectional) {
            s.direction = -along.xyz;
            s.distance = scene.environmentDistance;
            s.radiance = extent.xyz;
        } else {
            const vec3 offset = where.xyz - position;
            s.distance = length(offset);
            s.direction = offset / max(s.distance, 1e-30);
            s.hasTarget = true;
            // It may sit on a surface, which its position misses by rounding alone: what is nearer than that casts a shadow from however far away.
            const float gap = kLampGap * max(largestCoordinate(where.xyz), largestCoordinate(position));
            s.target = where.xyz - offset * min(1e-4, gap / max(s.distance, 1e-30));
            float falloff = distanceFalloff(s.distance * s.distance, where.w);
            if (kind == kLightSpot) falloff *= spotFalloff(-dot(s.direction, along.xyz), along.w, extent.w);
            if (kSpotsByAngle && kind == kLightSpotByAngle) falloff *= spotAngleFalloff(-dot(s.direction, along.xyz), along.w, extent.w);
            s.radiance = extent.xyz * falloff;
        }
    }
    return s;
}

// The radiance of a sample of an extended light, with the values at the offsets.
vec3 lightRadiance(SceneInfo scene, LightSample s, uint firstMaterial, uint firstTexel) {
    if (!s.extended) return s.radiance;
    if (s.material == kNone) return environmentRadiance(scene.environment, s.uv0, firstTexel);
    return emittedRadiance(s.material, materialTexel(s.material * kMaterialTexels + 1).w, s.uv0, s.uv1, firstMaterial, firstTexel);
}
