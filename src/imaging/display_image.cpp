// Values as pictures for the eye: exposed, signed, false colours.
#include "imaging/display_image.h"

#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

Image exposedPicture(const Image& image, float exposure) {
    Image result(image.width, image.height, 3);
    const float factor = std::exp2(exposure);
    for (std::size_t p = 0; p < image.pixels(); ++p)
        for (int c = 0; c < 3; ++c) {
            const float value = image.values[p * image.channels + std::min(c, image.channels - 1)];
            result.values[p * 3 + c] = std::clamp(value * factor, 0.f, 1.f);
        }
    return result;
}

Image signedPicture(const Image& values, double scale) {
    constexpr int kMinimumWidth = 128, kMargin = 6;
    constexpr int kMostEnlarged = 2048; // high
    const int zoom = std::max(1, std::min((kMinimumWidth + values.width - 1) / values.width, kMostEnlarged / values.height));
    const int width = values.width * zoom, height = values.height * zoom, whole = std::max(width, kMinimumWidth);
    Drawing drawing(Drawing::Target::Picture, whole, height + kMargin + kSignedLegendHeight);
    drawing.image((whole - width) / 2, 0, width, height, colorSigned(values, scale));
    drawSignedLegend(drawing, kMargin, height + kMargin, whole - 2 * kMargin, scale);
    return drawing.picture();
}

Color heatColor(double t) {
    static constexpr int kStops[][3] = {{24, 16, 60}, {88, 22, 118}, {186, 48, 92}, {243, 138, 46}, {255, 246, 200}};
    const double place = std::clamp(t, 0.0, 1.0) * 4;
    const int stop = std::min(int(place), 3);
    const auto channel = [&](int c) { return int(std::lround(kStops[stop][c] + (place - stop) * (kStops[stop + 1][c] - kStops[stop][c]))); };
    return displayColor(channel(0), channel(1), channel(2));
}

double heatScale(const Image& values) {
    float most = 0;
    for (const float v : values.values)
        if (std::isfinite(v))
            most = std::max(most, v);
    return most > 0 ? double(most) : 1;
}

Color labelColor(std::uint32_t number) {
    // Hues a golden angle apart, in three lightnesses.
    const double hue = std::fmod(number * 0.61803398874989485, 1.0) * 6, light = 0.55 + 0.2 * (number % 3);
    const auto channel = [&](double shift) {
        const double k = std::fmod(hue + shift, 6.0);
        return int(std::lround(255 * light * (1 - 0.55 * std::clamp(std::min(k, 4 - k), 0.0, 1.0))));
    };
    return displayColor(channel(5), channel(3), channel(1));
}

} // namespace cmpg
