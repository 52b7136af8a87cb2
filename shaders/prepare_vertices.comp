// After split_paths: workgroup counts for the vertices of this bounce; none, here and from here on, once copies found no place.
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
    if (counts[0].overflow != 0) counts[push.bounce].vertices = 0;
    counts[push.bounce].vertexGroups = groupCounts(counts[push.bounce].vertices, kVertexGroup);
    counts[push.bounce].sortGroups = groupCounts(counts[push.bounce].vertices, kTraceChunk);
}
