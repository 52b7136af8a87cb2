// A picture to draw into: images, text, lines.
#include "imaging/png_canvas.h"

#include "imaging/cairo_text.h"

#include <algorithm>
#include <cmath>
#include <string>

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

// A mask to draw into: how much of each pixel of a part of a picture is covered.
struct Mask {
    CairoSurface surface;
    CairoContext context;

    Mask(int width, int height) : surface(cairo_image_surface_create(CAIRO_FORMAT_A8, width, height)), context(cairo_create(surface.get())) {}

    float coverage(int x, int y) const {
        const unsigned char* const data = cairo_image_surface_get_data(surface.get());
        return float(data[std::ptrdiff_t(y) * cairo_image_surface_get_stride(surface.get()) + x]) / 255;
    }
};

// As the eye sees it: thin strokes keep their weight.
float mixed(float ground, float ink, float covered) {
    if (covered <= 0 || covered >= 1)
        return covered > 0 ? ink : ground;
    const float below = srgbEncode(std::clamp(ground, 0.f, 1.f)), above = srgbEncode(std::clamp(ink, 0.f, 1.f));
    return srgbDecode(below + covered * (above - below));
}

constexpr double kFontSize = 10; // whose capitals are 7 pixels high
constexpr int kCapitals = 7, kDescent = 3;

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

template <class Draw> void Canvas::blend(int x, int y, int width, int height, Color color, Draw&& draw) {
    const int left = std::clamp(x, 0, image_.width), top = std::clamp(y, 0, image_.height);
    const int right = std::clamp(x + width, left, image_.width), bottom = std::clamp(y + height, top, image_.height);
    if (left == right || top == bottom)
        return;
    Mask mask(right - left, bottom - top);
    cairo_translate(mask.context.get(), -left, -top);
    draw(mask.context.get());
    cairo_surface_flush(mask.surface.get());
    for (int j = top; j < bottom; ++j)
        for (int i = left; i < right; ++i) {
            const float covered = mask.coverage(i - left, j - top);
            for (int c = 0; c < 3; ++c)
                image_.at(i, j)[c] = mixed(image_.at(i, j)[c], color[std::size_t(c)], covered);
        }
}

void Canvas::line(double x0, double y0, double x1, double y1, Color color, int thickness) {
    const double middle = thickness % 2 ? 0.5 : 0; // of what would be whole pixels
    const double reach = thickness + 1, low = -reach, widest = image_.width + reach, highest = image_.height + reach;
    const int left = int(std::clamp(std::min(x0, x1) - reach, low, widest)), right = int(std::clamp(std::max(x0, x1) + reach, low, widest)) + 1;
    const int top = int(std::clamp(std::min(y0, y1) - reach, low, highest)), bottom = int(std::clamp(std::max(y0, y1) + reach, low, highest)) + 1;
    blend(left, top, right - left, bottom - top, color, [&](cairo_t* context) {
        cairo_set_line_width(context, thickness);
        cairo_set_line_cap(context, CAIRO_LINE_CAP_SQUARE);
        cairo_move_to(context, x0 + middle, y0 + middle);
        cairo_line_to(context, x1 + middle, y1 + middle);
        cairo_stroke(context);
    });
}

void Canvas::text(int x, int y, std::string_view text, Color color, int zoom) {
    const int baseline = y + kCapitals * zoom;
    blend(x - zoom, y - kDescent * zoom, textWidth(text, zoom) + 2 * zoom, (kCapitals + 2 * kDescent) * zoom, color, [&](cairo_t* context) {
        setFont(context, kFontSize * zoom);
        cairo_move_to(context, x, baseline);
        cairo_show_text(context, drawableText(text).c_str());
    });
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
    Mask mask(1, 1);
    setFont(mask.context.get(), kFontSize * zoom);
    cairo_text_extents_t extents;
    cairo_text_extents(mask.context.get(), drawableText(text).c_str(), &extents);
    return int(std::ceil(extents.x_advance));
}
int Canvas::textHeight(int zoom) {
    return kCapitals * zoom;
}

} // namespace cmpg
