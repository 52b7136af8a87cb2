// The parts of the bench; each prints its own table.
#pragma once

#include <string>

namespace cmpg::bench {

// Rays per second against single-ray Embree with two threads, and triangles per second of the hierarchy's build.
void traversal();

// Image, derivative pass and whole optimisation step; `scenes`: the folder of the bundled scenes.
void step(const std::string& scenes);

// Guided passes against unguided ones, and the rebuild of the guide against a step.
void guiding(const std::string& scenes);

// Kernels with what a scene needs against kernels with everything: passes, and starts without stored kernels.
void features(const std::string& scenes);

} // namespace cmpg::bench
