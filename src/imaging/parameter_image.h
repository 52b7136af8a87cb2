// Values of a parameter as an image in its own shape.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <span>

namespace cmpg {

template <class T> Image imageOfValues(const Parameter& parameter, std::span<const T> values) {
    Image image(int(parameter.width), int(parameter.height), int(parameter.channels));
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(values[i]);
    return image;
}
inline Image parameterImage(const Parameter& parameter, std::span<const float> values) { return imageOfValues(parameter, values); }
inline Image parameterImage(const Parameter& parameter, std::span<const double> values) { return imageOfValues(parameter, values); }

} // namespace cmpg
