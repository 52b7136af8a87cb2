// Reconstruction filters as scene files and users describe them.
#pragma once

#include "scene/scene.h"

#include <cmpg/filter.h>

namespace cmpg {

// Limits of widths, in pixels.
constexpr double kNarrowestFilter = 0.01, kWidestTent = 32, kWidestGaussian = 8;
constexpr double kTentRadius = 1, kGaussianDeviation = 0.5; // Mitsuba's defaults

PixelFilter tentFilter(double radius = kTentRadius);
PixelFilter gaussianFilter(double deviation = kGaussianDeviation); // ends at four deviations

// Error(Usage) on a width out of range.
PixelFilter pixelFilter(const v1::ReconstructionFilter& filter);

// As ReconstructionFilter::parse() reads it: equal for equal filters.
std::string nameOf(const PixelFilter& filter);

} // namespace cmpg
