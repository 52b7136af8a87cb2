// The index of an invocation among all items of a dispatch whose workgroups may be folded into y.

// A macro, because in a function above the kernel's local_size the compiler silently takes gl_WorkGroupSize for 1.
#define globalIndex() ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex)

// Group counts of an indirect dispatch of `items` invocations in workgroups of `size`, folded as the host folds them.
uvec3 groupCounts(uint items, uint size) {
    const uint groups = items / size + uint(items % size != 0);
    if (groups <= 65535) return uvec3(groups, 1, 1);
    const uint rows = (groups + 65534) / 65535;
    return uvec3((groups + rows - 1) / rows, rows, 1);
}
