// Reads and writes one binding through two declarations, as the portable variants of some kernels do.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 1) in;
layout(binding = 2, scalar) readonly buffer Words { uint at[]; } words;
layout(binding = 2, scalar) buffer Floats { float at[]; } floats;

void main() { floats.at[1] = uintBitsToFloat(words.at[0]); }
