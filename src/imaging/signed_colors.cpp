// Diverging colours for signed data: blue below zero, orange above, white at zero.
#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// Oklab to linear sRGB (Ottosson 2020). Lightness there is perceived lightness, whatever the hue.
Color fromOklab(double lightness, double a, double b) {
    const auto cube = [](double x) { return x * x * x; };
    const double l = cube(lightness + 0.3963377774 * a + 0.2158037573 * b);
    const double m = cube(lightness - 0.1055613458 * a - 0.0638541728 * b);
    const double s = cube(lightness - 0.0894841775 * a - 1.2914855480 * b);
    return {float(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s), float(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            float(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

constexpr double kPi = 3.14159265358979323846;
constexpr double kBlue = 255 * kPi / 180, kOrange = 55 * kPi / 180; // hue angles
constexpr double kLightest = 0.97, kDarkest = 0.46;
constexpr double kChroma = 0.11; // both hues reach it inside sRGB at every lightness used

double roundUpTwoDigits(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
    return std::ceil(value / unit - 1e-5) * unit; // 0.3f is a little more than 0.3
}

} // namespace

Color signedColor(double t) {
    if (std::isnan(t))
        return displayColor(128, 128, 128);
    t = std::clamp(t, -1.0, 1.0);
    const double strength = std::abs(t), hue = t < 0 ? kBlue : kOrange;
    const double lightness = kLightest - (kLightest - kDarkest) * strength;
    const double chroma = kChroma * std::min(1.0, 2 * strength); // full at half strength; beyond, only darker
    const Color color = fromOklab(lightness, chroma * std::cos(hue), chroma * std::sin(hue));
    return {std::clamp(color[0], 0.f, 1.f), std::clamp(color[1], 0.f, 1.f), std::clamp(color[2], 0.f, 1.f)};
}

Image channelMean(const Image& image) {
    Image mean(image.width, image.height, 1);
    for (std::size_t p = 0; p < image.pixels(); ++p) {
        double sum = 0;
        for (int c = 0; c < image.channels; ++c)
            sum += double(image.values[p * image.channels + c]);
        mean.values[p] = float(sum / image.channels);
    }
    return mean;
}

double signedScale(const Image& values) {
    std::vector<float> magnitudes;
    for (float v : values.values)
        if (std::isfinite(v))
            magnitudes.push_back(std::abs(v));
    if (magnitudes.empty())
        return 1;
    // Of few values the largest: a percentile would cut off what there is.
    const auto place = magnitudes.begin() + std::ptrdiff_t(std::ceil(0.995 * double(magnitudes.size()))) - 1;
    std::nth_element(magnitudes.begin(), place, magnitudes.end());
    float scale = *place;
    if (scale == 0)
        scale = *std::max_element(magnitudes.begin(), magnitudes.end()); // sparse gradients: less than one in 200 texels
    return scale > 0 ? roundUpTwoDigits(scale) : 1;
}

Image colorSigned(const Image& values, double scale) {
    Image colors(values.width, values.height, 3);
    for (std::size_t p = 0; p < values.pixels(); ++p) {
        const Color color = signedColor(double(values.values[p]) / scale);
        std::copy(color.begin(), color.end(), colors.values.begin() + std::ptrdiff_t(3 * p));
    }
    return colors;
}

void drawSignedLegend(Drawing& drawing, int x, int y, int width, double scale) {
    constexpr int kBar = 10;
    Image ramp(width, kBar, 1);
    for (int j = 0; j < kBar; ++j)
        for (int i = 0; i < width; ++i)
            ramp.at(i, j)[0] = float(2 * (i + 0.5) / width - 1);
    drawing.image(x, y, width, kBar, colorSigned(ramp, 1));
    char positive[24], negative[24];
    std::snprintf(positive, sizeof positive, "+%.4g", scale); // automatic scales have two digits, others are the user's
    std::snprintf(negative, sizeof negative, "-%.4g", scale);
    const int below = y + kBar + 4;
    drawing.label(x, below, negative);
    drawing.label(x + (width - Drawing::textWidth("0")) / 2, below, "0");
    drawing.label(x + width - Drawing::textWidth(positive), below, positive);
}

} // namespace cmpg
