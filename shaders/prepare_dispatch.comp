// After a bounce: workgroup counts for its shadow rays and for the next bounce's rays, read by the indirect dispatches that follow.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/bindings.h"
#include "shared/wavefront.h"
layout(local_size_x = 1) in;
#include "lib/dispatch.glsl"
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };

void main() {
    if (push.count == 0) return;
    const uint next = counts[push.bounce + 1].rays;
    counts[push.bounce].shadowGroups = groupCounts(counts[push.bounce].shadowRays, kTraceChunk);
    counts[push.bounce + 1].rayGroups = groupCounts(next, kTraceChunk);
    counts[push.bounce + 1].sortGroups = counts[push.bounce + 1].rayGroups;
    counts[push.bounce + 1].arrivalGroups = groupCounts(next, kVertexGroup);
    counts[push.bounce + 1].vertexGroups = counts[push.bounce + 1].arrivalGroups;
}
