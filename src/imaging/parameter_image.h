// Values of a parameter as an image in its own shape.
#pragma once

#include <cmpg/image.h>

#include <span>

namespace cmpg {

// `shape`: a parameter, of the scene or as the library describes it.
template <class Shape, class T> Image imageOfValues(const Shape& shape, std::span<const T> values) {
    Image image(int(shape.width), int(shape.height), int(shape.channels));
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(values[i]);
    return image;
}
template <class Shape> Image parameterImage(const Shape& shape, std::span<const float> values) { return imageOfValues(shape, values); }
template <class Shape> Image parameterImage(const Shape& shape, std::span<const double> values) { return imageOfValues(shape, values); }

} // namespace cmpg
