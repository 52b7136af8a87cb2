// Pictures of a comparison's report: signed derivatives at a common scale, values, the scene.
#include "lab/compare_pictures.h"

#include "imaging/exposure.h"
#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
SignedFigures signedFigures(const std::vector<CaptionedImage>& images) {
    constexpr int kLegendWidth = 256;
    const double scale = signedScale(channelMean(images.front().image));
    SignedFigures result;
    for (const CaptionedImage& image : images)
        result.figures.push_back({colorSigned(channelMean(image.image), scale), image.caption});
    Drawing legend(Drawing::Target::Picture, kLegendWidth, kSignedLegendHeight);
    drawSignedLegend(legend, 0, 0, kLegendWidth, scale);
    result.legend = "<p class=\"legend\"><img alt=\"from " + shortNumber(-scale) + " (blue) to " + shortNumber(scale) +
           " (orange)\" src=\"" + pngDataUri(legend.picture()) + "\"></p>\n";
    return result;
}

Image signedStrip(const std::vector<std::pair<std::string, Image>>& images) {
    constexpr int kEdge = 256, kGap = 8, kLetters = 20;
    const double scale = signedScale(channelMean(images.front().second));
    const int label = Drawing::capitals(kLetters) + kGap;
    const int count = int(images.size());
    Drawing drawing(Drawing::Target::Picture, count * (kEdge + kGap) + kGap, kGap + label + kEdge + kGap + kSignedLegendHeight + kGap);
    for (int i = 0; i < count; ++i) {
        const int x = kGap + i * (kEdge + kGap);
        drawing.label(x, kGap, images[std::size_t(i)].first, "#000000", kLetters);
        drawing.image(x, kGap + label, kEdge, kEdge, colorSigned(channelMean(images[std::size_t(i)].second), scale));
    }
    drawSignedLegend(drawing, kGap, 2 * kGap + label + kEdge, kEdge, scale);
    return drawing.picture();
}

std::vector<HtmlFigure> plainFigures(const std::vector<CaptionedImage>& images, bool expose) {
    const float factor = expose ? exposureFor({&images.front().image}) : 1;
    std::vector<HtmlFigure> figures;
    for (const CaptionedImage& image : images) {
        Image scaled = image.image;
        for (float& v : scaled.values)
            v = std::isfinite(v) ? std::clamp(v * factor, 0.f, 1.f) : 0.f;
        figures.push_back({std::move(scaled), image.caption});
    }
    return figures;
}

Image difference(const Image& a, const Image& b) {
    Image result = a;
    for (std::size_t i = 0; i < result.values.size(); ++i)
        result.values[i] -= b.values[i];
    return result;
}

} // namespace cmpg
