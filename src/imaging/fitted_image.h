// An image as large as a panel.
#pragma once

#include "scene/image.h"

namespace cmpg {

struct FittedSize {
    int width, height;
};
// Of the image below.
FittedSize fittedSize(const Image& image, int width, int height);

// `image` has 3 channels. Its pixels become blocks, or are averaged, to fit into width x height with their aspect kept.
Image fittedImage(const Image& image, int width, int height);

} // namespace cmpg
