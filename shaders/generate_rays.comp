// Camera rays of a batch: which pixel and sample each path belongs to, and where it starts.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "scene/features.glsl"
#include "shared/bindings.h"
#include "shared/batch.h"
#include "scene/queues.glsl"
#include "lib/sampler.glsl"
#include "lib/pixel_filter.glsl"
#include "lib/dispatch.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindBatch, scalar) uniform BatchBlock { Batch batch; };
QUEUE_UINT(pixelOffset, kBindPixelOffsets) // and behind those of all pixels and the end: the first sample of each in its sequence
layout(binding = kBindPaths, scalar) writeonly buffer Paths { uvec2 paths[]; };
layout(binding = kBindRays, scalar) writeonly buffer Rays { uvec4 rays[]; };

void main() {
    const uint path = globalIndex();
    if (push.count == 0 || path >= batch.paths) return;
    // The pixel whose run of samples contains this path.
    uint low = 0, high = batch.pixels - 1;
    // Where all pixels have as many samples as the second one, the search ends before it begins.
    const uint second = pixelOffset(min(1u, batch.pixels)), samples = max(pixelOffset(min(2u, batch.pixels)) - second, 1u);
    const uint guess = min(uint((float(path + samples - min(second, samples)) + 0.5) / float(samples)), high);
    if (pixelOffset(guess) <= path && path < pixelOffset(guess + 1)) low = high = guess;
    for (uint i = 0; i < 32 && low < high; ++i) {
        const uint middle = (low + high + 1) / 2;
        if (pixelOffset(middle) <= path) low = middle;
        else high = middle - 1;
    }
    const uint index = pixelOffset(batch.pixels + 1 + low) + path - pixelOffset(low) + (low == 0 ? batch.firstSample : 0);
    paths[path] = uvec2(low, index);

    const uint pixel = batch.firstPixel + low;
    const SampleKey key = SampleKey(streamKey(batch.seed.x, batch.seed.y, batch.step, batch.pass), pixel, index, 0u, 0u);
    const vec2 u = sampleSet(key, kSetCamera).xy;
    vec2 raster = vec2(pixel % batch.width, pixel / batch.width);
    if (kPixelFilter && batch.filterKind != kFilterBox) {
        // Within the picture: what lies outside of it counts for no pixel, as in Mitsuba.
        const vec2 middle = raster + 0.5, size = vec2(batch.width, batch.height);
        const vec2 low = max(-middle, vec2(-batch.filterRadius)), high = min(size - middle, vec2(batch.filterRadius));
        raster = middle + vec2(filterOffset(batch.filterKind, batch.filterRadius, batch.filterDeviation, low.x, high.x, u.x),
                               filterOffset(batch.filterKind, batch.filterRadius, batch.filterDeviation, low.y, high.y, u.y));
    } else {
        raster += u;
    }
    const vec2 plane = vec2(2.0 * raster.x / float(batch.width) - 1.0, 1.0 - 2.0 * raster.y / float(batch.height));
    const vec3 across = plane.x * batch.cameraRight + plane.y * batch.cameraUp;
    Ray ray;
    ray.path = batch.allLight != 0 ? path | kLightCounts : path;
    ray.pdf = 0.0;
    if (batch.orthographic != 0) {
        ray.origin = batch.cameraOrigin + across;
        ray.direction = batch.cameraForward;
    } else {
        ray.origin = batch.cameraOrigin;
        ray.direction = normalize(across + batch.cameraForward);
    }
    WRITE_RAY(rays, path, ray)
}
