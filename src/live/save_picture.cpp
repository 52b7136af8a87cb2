// What a session shows as files: pictures, the loss.
#include "live/save_picture.h"

#include "imaging/display_image.h"
#include "imaging/loss_curve.h"
#include "imaging/signed_colors.h"
#include "session/output.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

namespace cmpg {
namespace {

// One value per pixel in false colours; what is not finite stays black.
Image scalarPicture(const Image& values, double high) {
    Image picture(values.width, values.height, 3);
    for (std::size_t p = 0; p < values.pixels(); ++p) {
        const auto value = double(values.values[p]);
        const Color color = std::isfinite(value) ? heatColor(value / high) : kBlack;
        std::copy(color.begin(), color.end(), picture.values.begin() + std::ptrdiff_t(3 * p));
    }
    return picture;
}

Image labelPicture(const Image& labels) {
    Image picture(labels.width, labels.height, 3);
    for (std::size_t p = 0; p < labels.pixels(); ++p) {
        const Color color = labels.values[p] < 0 ? kBlack : labelColor(std::uint32_t(labels.values[p]));
        std::copy(color.begin(), color.end(), picture.values.begin() + std::ptrdiff_t(3 * p));
    }
    return picture;
}

Image directionPicture(const Image& directions) {
    Image picture = directions;
    for (float& v : picture.values)
        v = 0.5f * v + 0.5f;
    return picture;
}

Image display(LiveColors colors, const Image& image, const LiveLook& look) {
    switch (colors) {
    case LiveColors::Signed: {
        const Image mean = channelMean(image);
        const double scale = look.scale > 0 ? look.scale : signedScale(mean);
        return look.legend ? signedPicture(mean, scale) : colorSigned(mean, scale);
    }
    case LiveColors::Heat: return scalarPicture(image, look.scale > 0 ? look.scale : heatScale(image));
    case LiveColors::Directions: return directionPicture(image);
    case LiveColors::Labels: return labelPicture(image);
    case LiveColors::Plain: return exposedPicture(image, 0);
    case LiveColors::Radiance: break;
    }
    return exposedPicture(image, look.exposure);
}

} // namespace

void savePicture(LiveColors colors, const Image& image, const std::filesystem::path& file, const LiveLook& look) {
    if (file.extension() == ".png") {
        requireWritableFile(file, ".png");
        writePng(file, display(colors, image, look));
    } else {
        requireWritableFile(file, ".exr"); // refuses other endings
        writeExr(file, image);
    }
}

void saveLoss(std::span<const double> loss, const std::filesystem::path& file) {
    if (file.extension() == ".png") {
        requireWritableFile(file, ".png");
        constexpr int kWidth = 640, kHeight = 320, kBorder = 8;
        Drawing drawing(Drawing::Target::Picture, kWidth, kHeight);
        drawLossCurve(drawing, kBorder, kBorder, kWidth - 2 * kBorder, kHeight - 2 * kBorder, loss);
        writePng(file, drawing.picture());
    } else {
        requireWritableFile(file, ".csv"); // refuses other endings
        std::ostringstream rows;
        rows << std::setprecision(std::numeric_limits<double>::max_digits10) << "step,loss\n";
        for (std::size_t i = 0; i < loss.size(); ++i)
            rows << i << ',' << loss[i] << '\n';
        writeTextFile(file, rows.str());
    }
}

} // namespace cmpg
