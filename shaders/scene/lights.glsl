// Light sampling: one light by its selection probability, one point or direction on it.
// Expects lightTexel(), lightDensity() and what geometry.glsl, materials.glsl, alpha_mask.glsl and environment.glsl expect.

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

uint selectLight(uint count, float u) {
    uint low = 0, high = count - 1;
    for (uint i = 0; i < 32 && low < high; ++i) {
        const uint middle = (low + high) / 2;
        if (u < uintBitsToFloat(lightTexel(middle * kLightTexels).w)) high = middle;
        else low = middle + 1;
    }
    return low;
}

// density = 0 when there is nothing to gain from this light at `position`.
LightSample sampleLight(SceneInfo scene, vec3 position, vec3 u) {
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
    const uint light = selectLight(scene.lights, u.x);
    const uvec4 head = lightTexel(light * kLightTexels);
    const float probability = uintBitsToFloat(head.z);
    if (kTriangleLights && head.x == kLightTriangle) {
        const vec2 b = sampleTriangle(u.yz);
        if (kTexturedEmission) {
            const SurfacePoint p = surfacePoint(head.y, b);
            s.uv0 = p.uv0;
            s.uv1 = p.uv1;
        }
        const vec4 t0 = triangleTexel(3 * head.y), t1 = triangleTexel(3 * head.y + 1), t2 = triangleTexel(3 * head.y + 2);
        const vec3 point = t0.xyz + b.x * t1.xyz + b.y * t2.xyz;
        const vec3 offset = point - position;
        const float distance2 = dot(offset, offset);
        s.distance = sqrt(distance2);
        s.direction = offset / max(s.distance, 1e-30);
        const float cosLight = -dot(vec3(t0.w, t1.w, t2.w), s.direction);
        s.hasTarget = true;
        const float magnitude = max(largestCoordinate(t0.xyz), max(largestCoordinate(t0.xyz + t1.xyz), largestCoordinate(t0.xyz + t2.xyz)));
        s.target = offsetRayOrigin(point, vec3(t0.w, t1.w, t2.w), -s.direction, magnitude);
        s.material = triangleIndices(head.y).w;
        s.density = areaToSolidAngle(lightDensity(head.y), distance2, cosLight);
        if (kAlphaMask && isCutOut(head.y, b)) s.density = 0.0; // a hole emits nothing
    } else if (kEnvironmentLight && head.x == kLightEnvironment) {
        s.direction = sampleEnvironment(scene.environment, u.yz, s.uv0, s.density);
        s.distance = scene.environmentDistance;
    } else if (kPunctualLights) {
        const vec4 where = uintBitsToFloat(lightTexel(light * kLightTexels + 1));
        const vec4 along = uintBitsToFloat(lightTexel(light * kLightTexels + 2));
        const vec4 power = uintBitsToFloat(lightTexel(light * kLightTexels + 3));
        s.extended = false;
        s.density = probability;
        if (head.x == kLightDirectional) {
            s.direction = -along.xyz;
            s.distance = scene.environmentDistance;
            s.radiance = power.xyz;
        } else {
            const vec3 offset = where.xyz - position;
            s.distance = length(offset);
            s.direction = offset / max(s.distance, 1e-30);
            s.hasTarget = true;
            s.target = where.xyz - 1e-4 * offset; // it may sit on a surface
            float falloff = distanceFalloff(s.distance * s.distance, where.w);
            if (head.x == kLightSpot) falloff *= spotFalloff(-dot(s.direction, along.xyz), along.w, power.w);
            s.radiance = power.xyz * falloff;
        }
    }
    return s;
}

// The radiance of a sample of an extended light, with the values at the offsets.
vec3 lightRadiance(SceneInfo scene, LightSample s, uint frozenMaterials, uint frozenTexels) {
    if (!s.extended) return s.radiance;
    if (s.material == kNone) return environmentRadiance(scene.environment, s.uv0, frozenTexels);
    return emittedRadiance(s.material, materialTexel(s.material * kMaterialTexels + 1).w, s.uv0, s.uv1, frozenMaterials, frozenTexels);
}
