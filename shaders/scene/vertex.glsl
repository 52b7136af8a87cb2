// What the kernels share that shade vertices: what a path has collected, the weight of emission that it finds, words on the tape.
// Expects tape[], statistics[], push, and scene/queues.glsl with prefixes.

Prefix loadPrefix(uint ray, Copy copy) {
    Prefix prefix = Prefix(vec3(1), 0, vec3(0), 1);
    if (kDerivatives && kPrefix && push.bounce > 0) prefix = readPrefix(ray);
    if (kRoulette) {
        prefix.throughput *= copy.weight;
        prefix.tangent *= copy.weight;
        if (copy.index > 0) prefix.branch = copyBranch(prefix.branch, push.bounce, copy.index);
        prefix.copies = copy.copies;
    }
    return prefix;
}

bool isFinite(vec3 v) { return !any(isnan(v)) && !any(isinf(v)); }

uint dropped = 0; // factors of this vertex that are no numbers

vec3 keepFinite(vec3 v) {
    if (isFinite(v)) return v;
    ++dropped;
    return vec3(0);
}

// Says so in the statistics, once for all: a CPU driver goes through an atomic's lanes even if none takes it.
void countDropped() {
    if (dropped > 0) atomicAdd(statistics[kDroppedRadiance], dropped);
}

// MIS weight of emission found by a direction drawn with density `drawn` which light sampling picks with density `light`. Single directions are no
// light sample's.
float foundWeight(float drawn, float light) {
    if (kSingleDirections && drawn == kSingleDirection) return 1.0;
    return push.bounce == 0 ? 1.0 : misWeight(drawn, light);
}

void tapePut(uint slot, uint plane, float value) { tape[plane * push.count + slot] = floatBitsToUint(value); }

void tapePut3(uint slot, uint plane, vec3 value) {
    tapePut(slot, plane, value.x);
    tapePut(slot, plane + 1, value.y);
    tapePut(slot, plane + 2, value.z);
}

void tapeSurface(uint slot, uint material, vec2 uv0, vec2 uv1) {
    tape[kPlaneMaterial * push.count + slot] = material;
    tapePut(slot, kPlaneUv0, uv0.x);
    tapePut(slot, kPlaneUv0 + 1, uv0.y);
    if (kTexcoord1) {
        tapePut(slot, kPlaneUv1, uv1.x);
        tapePut(slot, kPlaneUv1 + 1, uv1.y);
    }
}

// The same local factors under the second set of values, for directions and lights drawn by the first.
struct SecondFactors {
    vec3 emission, direct, weight; // emission: where light is differentiated, else it is the same
};

void tapeSecond(uint slot, SecondFactors s) {
    tapePut3(slot, kPlaneSecond, s.direct);
    tapePut3(slot, kPlaneSecond + 3, s.weight);
    if (kSecondLight) tapePut3(slot, kPlaneSecond + kTapeSecond, s.emission);
}
