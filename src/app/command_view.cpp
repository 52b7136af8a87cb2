// view: an EXR image as a PNG to look at.
#include "app/commands.h"
#include "base/log.h"
#include "imaging/display_image.h"
#include "imaging/signed_colors.h"
#include "session/output.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <ostream>
#include <vector>

namespace cmpg {
namespace {

// Exposure that shows most of an image, where the one asked for shows next to nothing of it: lights in candela, for instance, make
// images of thousands.
std::optional<float> betterExposure(const Image& image, float exposure) {
    constexpr double kPlace = 0.95;                       // of all pixels, to become white
    constexpr float kDimmest = 0.02f, kBrightest = 10.f;  // where that pixel may lie, white being 1
    std::vector<float> brightness;
    for (std::size_t p = 0; p < image.pixels(); ++p) {
        const float* first = &image.values[p * image.channels];
        const float value = *std::max_element(first, first + std::min(image.channels, 3));
        if (std::isfinite(value))
            brightness.push_back(value);
    }
    if (brightness.empty())
        return {};
    const auto place = brightness.begin() + std::ptrdiff_t(kPlace * double(brightness.size() - 1));
    std::nth_element(brightness.begin(), place, brightness.end());
    const float shown = *place * std::exp2(exposure);
    if (!(*place > 0) || (shown >= kDimmest && shown <= kBrightest))
        return {};
    return -std::round(2 * std::log2(*place)) / 2;
}

} // namespace

ExitStatus runView(const Options& options, Report& report) {
    requireWritableFile(options.output, ".png");
    const Image image = readImage(options.input, {.layer = options.layer}).image;
    report.width = image.width;
    report.height = image.height;
    if (options.isSigned) {
        const Image values = channelMean(image);
        const double scale = (options.scale ? double(*options.scale) : signedScale(values)) * std::exp2(-double(options.exposure));
        writePng(options.output, signedPicture(values, scale));
        char line[96];
        std::snprintf(line, sizeof line, "scale: -%.4g (blue) to +%.4g (orange)\n", scale, scale);
        textOut(options) << line;
        report.extra["scale"] = scale;
    } else {
        writePng(options.output, exposedPicture(image, options.exposure));
        if (const auto better = betterExposure(image, options.exposure)) {
            char line[96];
            std::snprintf(line, sizeof line, "the picture is nearly all %s: try --exposure %g", *better < options.exposure ? "white" : "black",
                          double(*better));
            logWarn(line);
        }
    }
    report.outputs.emplace_back("image", options.output);
    return ExitStatus::Done;
}

} // namespace cmpg
