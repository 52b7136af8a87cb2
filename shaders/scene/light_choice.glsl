// Which of several light samples to take: resampled importance sampling (Talbot, Cline and Egbert 2005).
// Expects what scene/lights.glsl expects.

struct LightChoice {
    vec3 u; // the numbers of the sample chosen, for sampleLight()
    float weight; // on the sample's estimate: keeps the expectation that a single sample would have
};

// What a light sample brings to the surface without shadow, divided by its density, up to a factor that all share. Lights are selected by
// power, so their radiance cancels; what is left is where they are, how they are turned, and how the surface scatters: its sampling density,
// in which its colour cancels too.
float expectedLight(SceneInfo scene, LightRecord light, vec3 position, Surface surface, vec3 normal, vec3 wo, vec3 u) {
    const uint kind = lightKind(light);
    const vec4 where = light.where, along = light.along, extent = light.extent;
    vec3 direction = vec3(0);
    float brought = 0.0; // per power
    if (kTriangleLights && kind == kLightTriangle) {
        const vec2 b = sampleTriangle(u.yz);
        const vec3 offset = where.xyz + b.x * along.xyz + b.y * extent.xyz - position;
        const float distance2 = max(dot(offset, offset), 1e-30);
        direction = offset * inversesqrt(distance2);
        const vec3 front = vec3(where.w, along.w, extent.w);
        brought = max(0.0, -dot(front, direction)) / (kPi * distance2);
    } else if (kEnvironmentLight && kind == kLightEnvironment) {
        vec2 uv;
        float density;
        direction = sampleEnvironment(scene.environment, u.yz, uv, density);
        brought = where.w; // about, for what scattered rays do not find: directions are drawn in proportion to the radiance above the mean
    } else if (kPunctualLights && kind == kLightDirectional) {
        direction = -along.xyz;
        brought = where.w;
    } else if (kPunctualLights) {
        const vec3 offset = where.xyz - position;
        const float distance2 = dot(offset, offset);
        direction = offset * inversesqrt(max(distance2, 1e-30));
        brought = distanceFalloff(distance2, where.w) / (4.0 * kPi);
        const float cone = max(1.0 - 0.5 * (along.w + extent.w), 1e-6);
        if (kind == kLightSpot) brought *= 2.0 * spotFalloff(-dot(direction, along.xyz), along.w, extent.w) / cone;
        if (kSpotsByAngle && kind == kLightSpotByAngle) brought *= 2.0 * spotAngleFalloff(-dot(direction, along.xyz), along.w, extent.w) / cone;
    }
    // Where values are offset from those that sampling goes by, another side of the surface may be lit.
    const float white = max(dot(facing(normal, wo), direction), kFrozen || kDifference ? 0.02 : 0.0) * kInvPi;
    // The white share stays where the lobes send nothing, but a derivative may.
    return brought * (hasSpecular(surface) ? mix(white, bsdfPdf(surface, normal, wo, direction), 0.9) : white);
}

// `normal` may point away from where the path came from, as anywhere. u.w: which one is taken.
LightChoice chooseLightSample(SceneInfo scene, FewLights few, vec3 position, Surface surface, vec3 normal, vec3 wo, vec4 u) {
    // Steps of an additive sequence that fills the cube evenly: every candidate is distributed as the first one is.
    const vec3 step = vec3(0.8191725134, 0.6710436067, 0.5497004779);
    LightChoice choice = LightChoice(u.xyz, 1.0);
    if (kLightCandidates == 1) return choice;
    const uint candidates = kLightCandidates == 0 ? scene.lightCandidates : kLightCandidates;
    float total = 0.0, chosen = 0.0, remaining = u.w;
    for (uint i = 0; i < candidates; ++i) {
        const vec3 candidate = fract(u.xyz + float(i) * step);
        const float expected = expectedLight(scene, selectedLight(few, scene.lights, candidate.x), position, surface, normal, wo, candidate);
        total += expected;
        const float share = total > 0.0 ? expected / total : 0.0;
        if (remaining < share) {
            choice.u = candidate;
            chosen = expected;
            remaining /= share;
        } else {
            remaining = (remaining - share) / max(1.0 - share, 1e-20);
        }
    }
    choice.weight = chosen > 0.0 ? total / (float(candidates) * chosen) : 0.0;
    return choice;
}
