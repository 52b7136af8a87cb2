// Turns the queue lengths of a bounce into workgroup counts for the indirect dispatches that follow.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "shared/bindings.h"
#include "shared/wavefront.h"
layout(local_size_x = 1) in;
layout(constant_id = 0) const uint kTraceItems = 64; // rays a workgroup of the tracing kernels takes
layout(constant_id = 1) const uint kShadowItems = 64;
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
    counts[push.bounce].rayGroups = groupsFor(counts[push.bounce].rays, kTraceItems);
    counts[push.bounce].shadowGroups = groupsFor(counts[push.bounce].shadowRays, kShadowItems);
}
