// The index of an invocation among all items of a dispatch whose workgroups may be folded into y.

// A macro, because in a function above the kernel's local_size the compiler silently takes gl_WorkGroupSize for 1.
#define globalIndex() ((gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex)

// After the places first .. first + count - 1 of a queue were taken: the group count of the indirect dispatch over it, in workgroups of `size`, grows with its
// last place. Most of the time it does not, and there is no atomic. A pool holds fewer than 65 536 workgroups (src/render/wavefront.cpp), which fit into x.
#define GROW_GROUPS(groups, first, count, size) \
    if (((first) + (count) + (size) - 1) / (size) > ((first) + (size) - 1) / (size)) atomicMax((groups).x, ((first) + (count) + (size) - 1) / (size));
