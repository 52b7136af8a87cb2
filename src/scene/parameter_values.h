// Values of parameters: read, and set within their range.
#pragma once

#include "scene/scene.h"

#include <span>

namespace cmpg {

// Current values, also of parameters that are kept as bytes.
std::vector<float> valuesOf(const Parameter& parameter);

// entries() values from one number for all, or one per channel. Error(Usage) on another number of them.
std::vector<float> filled(const Parameter& parameter, std::span<const float> numbers);

// Sets entries() values. Error(Usage) where one is out of range by more than rounding; what rounding did is clamped.
void setValues(Parameter& parameter, std::vector<float> values);

} // namespace cmpg
