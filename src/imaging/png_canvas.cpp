// A picture to draw into: images, text, lines.
#include "imaging/png_canvas.h"

#include "imaging/bitmap_font.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// Mean over the pixels that a box of image coordinates covers, weighted by the covered area.
Color boxMean(const Image& image, double x0, double y0, double x1, double y1) {
    std::array<double, 3> sum{};
    double area = 0;
    for (int y = int(y0); y < std::min<double>(std::ceil(y1), image.height); ++y)
        for (int x = int(x0); x < std::min<double>(std::ceil(x1), image.width); ++x) {
            const double weight = (std::min(x1, x + 1.0) - std::max(x0, double(x))) * (std::min(y1, y + 1.0) - std::max(y0, double(y)));
            for (int c = 0; c < 3; ++c)
                sum[c] += weight * double(image.at(x, y)[c]);
            area += weight;
        }
    if (area <= 0)
        return kBlack;
    return {float(sum[0] / area), float(sum[1] / area), float(sum[2] / area)};
}

} // namespace

Color displayColor(int red, int green, int blue) {
    return {srgbDecode(float(red) / 255), srgbDecode(float(green) / 255), srgbDecode(float(blue) / 255)};
}

Canvas::Canvas(int width, int height, Color background) : image_(width, height, 3) {
    rectangle(0, 0, width, height, background);
}

void Canvas::set(int x, int y, Color color) {
    if (x >= 0 && y >= 0 && x < image_.width && y < image_.height)
        std::copy(color.begin(), color.end(), image_.at(x, y));
}

void Canvas::rectangle(int x, int y, int width, int height, Color color) {
    for (int j = std::max(0, y); j < std::min(y + height, image_.height); ++j)
        for (int i = std::max(0, x); i < std::min(x + width, image_.width); ++i)
            set(i, j, color);
}

void Canvas::line(double x0, double y0, double x1, double y1, Color color, int thickness) {
    const int steps = std::max(1, int(std::ceil(std::max(std::abs(x1 - x0), std::abs(y1 - y0)))));
    for (int i = 0; i <= steps; ++i) {
        const double t = double(i) / steps;
        const int x = int(std::lround(x0 + t * (x1 - x0))), y = int(std::lround(y0 + t * (y1 - y0)));
        rectangle(x - thickness / 2, y - thickness / 2, thickness, thickness, color);
    }
}

void Canvas::text(int x, int y, std::string_view text, Color color, int zoom) {
    for (const char character : text) {
        for (int j = 0; j < kGlyphHeight + kGlyphDescent; ++j)
            for (int i = 0; i < kGlyphWidth; ++i)
                if (glyphPixel(character, i, j))
                    rectangle(x + i * zoom, y + j * zoom, zoom, zoom, color);
        x += kGlyphAdvance * zoom;
    }
}

void Canvas::picture(int x, int y, int width, int height, const Image& image) {
    double scale = std::min(double(width) / image.width, double(height) / image.height);
    if (scale > 1)
        scale = std::floor(scale); // whole blocks, so that pixels stay visible as such
    const int w = std::max(1, int(image.width * scale)), h = std::max(1, int(image.height * scale));
    x += (width - w) / 2;
    for (int j = 0; j < h; ++j)
        for (int i = 0; i < w; ++i)
            set(x + i, y + j,
                boxMean(image, double(i) * image.width / w, double(j) * image.height / h, double(i + 1) * image.width / w,
                        double(j + 1) * image.height / h));
}

int Canvas::textWidth(std::string_view text, int zoom) {
    return text.empty() ? 0 : int(text.size()) * kGlyphAdvance * zoom - zoom;
}
int Canvas::textHeight(int zoom) {
    return kGlyphHeight * zoom;
}

} // namespace cmpg
