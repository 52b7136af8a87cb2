// The mixture weights of the guide on the host, compiled from what the kernels run.
#pragma once

#include "guiding/field/sd_tree.h"
#include "guiding/sampling.h"

#include <array>

namespace cmpg {

// Weights of P, D+, D- for a path straight from the camera: its throughput is 1, the derivative of its throughput 0. `mean`: of the cell.
// Bsdf and Auto stand for conditional sampling.
std::array<double, 3> mixtureOfCameraPath(Sampling sampling, const GuideMass& mean);

} // namespace cmpg
