// The environment map: its radiance in a direction and the density light sampling picks that direction with.
// Expects kBindValues and kBindEnvironmentCdf to be declared as valueTexel() and environmentCdf().

vec3 toEnvironment(EnvironmentInfo e, vec3 d) { return rotateY(d, e.cosRotation, -e.sinRotation); }
vec3 fromEnvironment(EnvironmentInfo e, vec3 d) { return rotateY(d, e.cosRotation, e.sinRotation); }

vec3 environmentRadiance(EnvironmentInfo e, vec2 uv, uint firstTexel) {
    const TexelWeights t = environmentTexelWeights(uv, e.width, e.height);
    const uint o = e.texels + firstTexel;
    return t.weight.x * valueTexel(o + t.index.x).xyz + t.weight.y * valueTexel(o + t.index.y).xyz + t.weight.z * valueTexel(o + t.index.z).xyz +
           t.weight.w * valueTexel(o + t.index.w).xyz;
}

// Rows as sampling sees them, from pole to pole: the only row of a map holds for all latitudes.
uint environmentRows(EnvironmentInfo e) { return max(e.height, 2u); }

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

// The corners of a cell, as sampling sees them.
vec4 environmentCorners(EnvironmentInfo e, uvec2 cell) {
    const uint left = e.texels + cell.y * e.width, right = cell.x + 1 < e.width ? cell.x + 1 : 0;
    const vec3 a = valueTexel(left + cell.x).xyz, b = valueTexel(left + right).xyz;
    const uint below = left + (e.height > 1 ? e.width : 0);
    const vec3 c = valueTexel(below + cell.x).xyz, d = valueTexel(below + right).xyz;
    const vec4 sums = vec4(a.x + a.y + a.z, b.x + b.y + b.z, c.x + c.y + c.z, d.x + d.y + d.z);
    return environmentCellCorners(max(vec4(0), sums - e.compensation));
}

// Density light sampling picks a direction of the map's own frame with, the selection of the environment included.
float environmentDensity(EnvironmentInfo e, vec3 local, vec2 uv) {
    const uint rows = environmentRows(e);
    const uvec2 cell = environmentCell(uv, e.width, rows);
    const float marginal = environmentCdf(cell.y) - environmentCdfBefore(0, cell.y);
    const uint base = rows - 1 + cell.y * e.width;
    const float conditional = environmentCdf(base + cell.x) - environmentCdfBefore(base, cell.x);
    const vec2 inside = vec2(fract(uv.x * float(e.width) - 0.5), clamp(uv.y * float(rows - 1) - float(cell.y), 0.0, 1.0));
    return environmentCellDensity(environmentCorners(e, cell), inside, e.probability * marginal * conditional, length(local.xz), e.width, rows);
}

const float kHalfStep = 1.0 / 33554432.0; // of random numbers

// Direction in world space with its map coordinates; density as above.
vec3 sampleEnvironment(EnvironmentInfo e, vec2 u, OUT(vec2) uv, OUT(float) density) {
    const uint rows = environmentRows(e);
    const uint row = searchEnvironmentCdf(0, rows - 1, u.y);
    const float m0 = environmentCdfBefore(0, row), m1 = environmentCdf(row);
    const uint base = rows - 1 + row * e.width;
    const uint column = searchEnvironmentCdf(base, e.width, u.x);
    const float c0 = environmentCdfBefore(base, column), c1 = environmentCdf(base + column);
    // All are multiples of 2^-24: half a step more, so that the few numbers that lead to a dim cell spread evenly over it.
    const float fx = clamp(((u.x - c0) + kHalfStep) / max(c1 - c0, 1e-20), 0.0, 1.0);
    const float fy = clamp(((u.y - m0) + kHalfStep) / max(m1 - m0, 1e-20), 0.0, 1.0);
    const vec4 corners = environmentCorners(e, uvec2(column, row));
    const vec2 inside = sampleEnvironmentCell(corners, vec2(fx, fy));
    const float across = (float(column) + 0.5 + inside.x) / float(e.width);
    uv = vec2(across >= 1.0 ? across - 1.0 : across, min((float(row) + inside.y) / float(rows - 1), 1.0));
    float sinTheta;
    const vec3 local = environmentPoint(uv.x, row, inside.y, rows, sinTheta);
    density = environmentCellDensity(corners, inside, e.probability * (m1 - m0) * (c1 - c0), sinTheta, e.width, rows);
    return fromEnvironment(e, local);
}
