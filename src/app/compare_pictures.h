// Pictures of a comparison's report: signed derivatives at a common scale, values, the scene.
#pragma once

#include "app/html.h"

#include <string>
#include <utility>
#include <vector>

namespace cmpg {

struct CaptionedImage {
    Image image;
    std::string caption; // HTML
};

// All at the scale of the first, with a legend that says it; HTML.
std::string signedFigures(const std::vector<CaptionedImage>& images);
// Linear values, clamped to [0,1]; one factor for all brings the first's 95th percentile to white where it is far from it.
std::string plainFigures(const std::vector<CaptionedImage>& images, bool expose);
Image difference(const Image& a, const Image& b);

} // namespace cmpg
