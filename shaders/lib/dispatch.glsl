// The index of an invocation among all items of a dispatch whose workgroups may be folded into y.
uint globalIndex() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationIndex;
}
