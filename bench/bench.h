// The parts of the bench; each prints its own table.
#pragma once

namespace cmpg::bench {

// Rays per second against single-ray Embree with two threads, and triangles per second of the hierarchy's build.
void traversal();

} // namespace cmpg::bench
