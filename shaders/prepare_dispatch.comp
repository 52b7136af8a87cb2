// Turns the queue lengths of a bounce into workgroup counts for the indirect dispatches that follow.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/bindings.h"
#include "shared/wavefront.h"
layout(local_size_x = 1) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };

// At most 65 535 workgroups a dimension; the rest folds into y.
uvec3 groupsFor(uint items, uint perGroup) {
    const uint groups = (items + perGroup - 1) / perGroup;
    const uint rows = (groups + 65534) / 65535;
    return rows <= 1 ? uvec3(groups, 1, 1) : uvec3(65535, rows, 1);
}

void main() {
    if (push.count == 0) return;
    const uint rays = counts[push.bounce].rays;
    counts[push.bounce].rayGroups = groupsFor(rays, kTraceChunk);
    counts[push.bounce].shadowGroups = groupsFor(counts[push.bounce].shadowRays, kTraceChunk);
    counts[push.bounce].vertexGroups = groupsFor(rays, kVertexGroup);
}
