// view: an EXR image as a PNG to look at.
#include "app/commands.h"
#include "app/output.h"
#include "app/signed_colors.h"

#include <algorithm>
#include <cmath>
#include <ostream>

namespace cmpg {
namespace {

Image exposed(const Image& image, float exposure) {
    Image result(image.width, image.height, 3);
    const float factor = std::exp2(exposure);
    for (std::size_t p = 0; p < image.pixels(); ++p)
        for (int c = 0; c < 3; ++c) {
            const float value = image.values[p * image.channels + std::min(c, image.channels - 1)];
            result.values[p * 3 + c] = std::clamp(value * factor, 0.f, 1.f);
        }
    return result;
}

// The image over its legend. Small images (gradients of textures) are enlarged so that the legend has room.
Image withLegend(const Image& values, double scale) {
    constexpr int kMinimumWidth = 128, kMargin = 6;
    const int zoom = std::max(1, (kMinimumWidth + values.width - 1) / values.width);
    const int width = values.width * zoom, height = values.height * zoom;
    Canvas canvas(width, height + kMargin + kSignedLegendHeight);
    canvas.picture(0, 0, width, height, colorSigned(values, scale));
    drawSignedLegend(canvas, kMargin, height + kMargin, width - 2 * kMargin, scale);
    return canvas.image();
}

} // namespace

ExitCode runView(const Options& options, Report& report) {
    requireWritableFile(options.output, ".png");
    const Image image = readImage(options.input).image;
    report.width = image.width;
    report.height = image.height;
    if (options.isSigned) {
        const Image values = channelMean(image);
        const double scale = (options.scale ? double(*options.scale) : signedScale(values)) * std::exp2(-double(options.exposure));
        writePng(options.output, withLegend(values, scale));
        char line[96];
        std::snprintf(line, sizeof line, "scale: -%.3g (blue) to +%.3g (orange)\n", scale, scale);
        textOut(options) << line;
        report.extra["scale"] = scale;
    } else {
        writePng(options.output, exposed(image, options.exposure));
    }
    report.outputs.emplace_back("image", options.output);
    return ExitCode::Done;
}

} // namespace cmpg
