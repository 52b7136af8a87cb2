// The environment map: its radiance in a direction and the density light sampling picks that direction with.
// Expects kBindValues and kBindEnvironmentCdf to be declared as valueTexel() and environmentCdf().

vec3 toEnvironment(EnvironmentInfo e, vec3 d) { return rotateY(d, e.cosRotation, -e.sinRotation); }
vec3 fromEnvironment(EnvironmentInfo e, vec3 d) { return rotateY(d, e.cosRotation, e.sinRotation); }

vec3 environmentRadiance(EnvironmentInfo e, vec2 uv, uint frozenTexels) {
    const TexelWeights t = environmentTexelWeights(uv, e.width, e.height);
    const uint o = e.texels + frozenTexels;
    return t.weight.x * valueTexel(o + t.index.x).xyz + t.weight.y * valueTexel(o + t.index.y).xyz + t.weight.z * valueTexel(o + t.index.z).xyz +
           t.weight.w * valueTexel(o + t.index.w).xyz;
}

// First index of cdf[base .. base + count) whose value exceeds u.
uint searchEnvironmentCdf(uint base, uint count, float u) {
    uint low = 0, high = count - 1;
    for (uint i = 0; i < 16 && low < high; ++i) { // maps are at most 8192 wide
        const uint middle = (low + high) / 2;
        if (u < environmentCdf(base + middle)) high = middle;
        else low = middle + 1;
    }
    return low;
}

float environmentCdfBefore(uint base, uint i) { return i == 0 ? 0.0 : environmentCdf(base + i - 1); }

// Solid-angle density of the cell (column, row) among environment directions.
float environmentCellDensity(EnvironmentInfo e, uint column, uint row) {
    const uint rows = e.height - 1;
    const float marginal = environmentCdf(row) - environmentCdfBefore(0, row);
    const uint base = rows + row * e.width;
    const float conditional = environmentCdf(base + column) - environmentCdfBefore(base, column);
    return marginal * conditional / environmentCellSolidAngle(row, e.width, e.height);
}

// Density light sampling picks `uv` with, the selection of the environment included.
float environmentDensity(EnvironmentInfo e, vec2 uv) {
    const uvec2 cell = environmentCell(uv, e.width, e.height);
    return e.probability * environmentCellDensity(e, cell.x, cell.y);
}

const float kHalfStep = 1.0 / 33554432.0; // of random numbers

// Direction in world space with its map coordinates; density as above.
vec3 sampleEnvironment(EnvironmentInfo e, vec2 u, OUT(vec2) uv, OUT(float) density) {
    const uint rows = e.height - 1;
    const uint row = searchEnvironmentCdf(0, rows, u.y);
    const float m0 = environmentCdfBefore(0, row), m1 = environmentCdf(row);
    const uint base = rows + row * e.width;
    const uint column = searchEnvironmentCdf(base, e.width, u.x);
    const float c0 = environmentCdfBefore(base, column), c1 = environmentCdf(base + column);
    // All are multiples of 2^-24: half a step more, so that the few numbers that lead to a dim cell spread evenly over it.
    const float fx = clamp(((u.x - c0) + kHalfStep) / max(c1 - c0, 1e-20), 0.0, 1.0);
    const float fy = clamp(((u.y - m0) + kHalfStep) / max(m1 - m0, 1e-20), 0.0, 1.0);
    const vec3 local = sampleEnvironmentCell(uvec2(column, row), e.width, e.height, vec2(fx, fy));
    uv = environmentUv(local);
    density = e.probability * (m1 - m0) * (c1 - c0) / environmentCellSolidAngle(row, e.width, e.height);
    return fromEnvironment(e, local);
}
