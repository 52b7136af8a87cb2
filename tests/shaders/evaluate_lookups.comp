// Evaluates what the renderer's kernels look up or convert: fixed point, Sobol sets, texel weights, cells of an environment map.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
const bool kSobol = true;
#include "lib/environment.glsl"
#include "lib/fixed_point.glsl"
#include "lib/sampler.glsl"
#include "lib/texel.glsl"
#include "lib/dispatch.glsl"

struct Query {
    float number, scale;
    uint index;
    uvec4 key;
    vec2 uv;
    uint width, height, wrapU, wrapV, nearest;
    vec3 direction;
};

struct Result {
    uvec2 words;
    uint fits;
    vec4 sobol;
    uvec4 texels;
    vec4 weights;
    uvec4 environmentTexels;
    vec4 environmentWeights;
    vec2 environmentUv;
    uvec2 cell; // of uv
    vec3 cellPoint; // a direction in that cell
    float sinTheta; // of it
};

layout(binding = 0, scalar) readonly buffer Queries { Query queries[]; };
layout(binding = 1, scalar) writeonly buffer Results { Result results[]; };
layout(push_constant) uniform Push { uint count; };

void main() {
    const uint i = globalIndex();
    if (i >= count) return;
    const Query q = queries[i];
    Result r;
    r.fits = toFixedPoint(q.number, q.scale, r.words) ? 1u : 0u;
    r.sobol = sobolSet(q.index, q.key);
    const TexelWeights t = texelWeights(q.uv, q.width, q.height, q.wrapU, q.wrapV, q.nearest != 0u);
    r.texels = t.index;
    r.weights = t.weight;
    const TexelWeights e = environmentTexelWeights(q.uv, q.width, q.height);
    r.environmentTexels = e.index;
    r.environmentWeights = e.weight;
    r.environmentUv = environmentUv(q.direction);
    const vec2 inside = vec2(q.uv.x - floor(q.uv.x), q.uv.y - floor(q.uv.y));
    r.cell = environmentCell(inside, q.width, q.height);
    const vec2 point = sampleEnvironmentCell(environmentCellCorners(vec4(inside.x, inside.y, 1.0 - inside.x, 0.0)), inside);
    r.cellPoint = environmentPoint(point.x, r.cell.y, point.y, q.height, r.sinTheta);
    results[i] = r;
}
