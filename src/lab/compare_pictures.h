// Pictures of a comparison's report: signed derivatives at a common scale, values, the scene.
#pragma once

#include "imaging/html.h"

#include <string>
#include <utility>
#include <vector>

namespace cmpg {

constexpr std::size_t kMostPictured = 4; // parameters; all are in the files
constexpr std::size_t kFewestTexels = 4; // a picture of less shows nothing

struct CaptionedImage {
    Image image;
    std::string caption; // HTML
};

struct SignedFigures {
    std::vector<HtmlFigure> figures;
    std::string legend; // HTML: the colours with their values

    std::string html() const { return htmlFigures(figures) + legend; }
};
// All at the scale of the first.
SignedFigures signedFigures(const std::vector<CaptionedImage>& images);
// The same in one picture, side by side, each under its plain name, with the legend.
Image signedStrip(const std::vector<std::pair<std::string, Image>>& images);
// Linear values, clamped to [0,1]. `expose`: one factor for all brings the first's 95th percentile to white where it is far from it.
std::vector<HtmlFigure> plainFigures(const std::vector<CaptionedImage>& images, bool expose);
Image difference(const Image& a, const Image& b);

} // namespace cmpg
