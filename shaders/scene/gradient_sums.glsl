// Gradient sums as 64-bit integers in units of 1/batch.gradientScale: the order of additions does not matter, so results do not depend on
// scheduling. A dispatch serves the entries of one slice, since a binding's range is limited.
layout(constant_id = kFeatureCount) const uint kSlices = 1;
#ifdef CMPG_PORTABLE
layout(binding = kBindGradients, scalar) buffer Gradients { uvec2 gradients[]; };
#else
layout(binding = kBindGradients, scalar) buffer Gradients { int64_t gradients[]; };
#endif
