// Writes its specialization constants; the workgroup size is one of them, and id 3 is left out.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x_id = 0) in;
layout(local_size_x = 32) in;
layout(constant_id = 1) const bool kFlag = false;
layout(constant_id = 2) const float kScale = 1.5;
layout(constant_id = 4) const uint kCount = 7;
layout(binding = 9, scalar) writeonly buffer Output { uint size, flag; float scale; uint count; } result;

void main() {
    if (gl_GlobalInvocationID.x > 0) return;
    result.size = gl_WorkGroupSize.x;
    result.flag = kFlag ? 1 : 0;
    result.scale = kScale;
    result.count = kCount;
}
