// Values as pictures for the eye: exposed, signed, false colours.
#pragma once

#include "imaging/color.h"

#include <cstdint>

namespace cmpg {

// Three channels in [0,1], of values times 2^exposure; one channel becomes grey.
Image exposedPicture(const Image& image, float exposure);

// One channel in the colours of signed data, over its legend. Small images (gradients of textures) are enlarged so that the legend has room; narrow ones that
// would become too high by that stand over its middle.
Image signedPicture(const Image& values, double scale);

// From night blue over red to cream: lightness grows all the way. `t` in [0,1], clamped.
Color heatColor(double t);

// The value that gets the lightest of these colours: the largest. 1 where none is above zero.
double heatScale(const Image& values);

// A colour for a number that only names something: neighbouring numbers get colours far apart.
Color labelColor(std::uint32_t number);

} // namespace cmpg
