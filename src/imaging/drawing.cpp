// Plots and sheets of pictures, drawn by Cairo.
#include "imaging/drawing.h"

#include "base/error.h"
#include "imaging/cairo_text.h"
#include "imaging/fitted_image.h"
#include "imaging/html.h"
#include "scene/image_decode.h"

#include <algorithm>
#include <cairo/cairo-svg.h>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace cmpg {

struct Drawing::Impl {
    std::string written, title; // of an SVG
    CairoSurface surface;
    CairoContext context;

    Impl(Target target, double width, double height, const std::string& t) : title(t) {
        if (target == Target::Svg) {
            surface.reset(cairo_svg_surface_create_for_stream(
                [](void* to, const unsigned char* data, unsigned size) {
                    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(data), size);
                    return CAIRO_STATUS_SUCCESS;
                },
                &written, width, height));
            cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PX);
        } else {
            surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, int(width), int(height)));
            if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS)
                throw Error(ErrorKind::Output, "cannot draw a picture of " + std::to_string(int(width)) + " x " + std::to_string(int(height)),
                            "a picture has at most 32767 pixels along an edge, and must fit into memory", "use smaller images, or fewer of them");
        }
        context.reset(cairo_create(surface.get()));
        cairo_set_source_rgb(context.get(), 1, 1, 1);
        cairo_paint(context.get());
        cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
    }

    void color(const std::string& name) {
        const long rgb = std::strtol(name.c_str() + 1, nullptr, 16);
        cairo_set_source_rgb(context.get(), double(rgb >> 16) / 255, double(rgb >> 8 & 255) / 255, double(rgb & 255) / 255);
    }
    void stroke(const std::string& name, double width) {
        color(name);
        cairo_set_line_width(context.get(), width);
        cairo_stroke(context.get());
    }
    void letters(const std::string& text, Anchor anchor, const std::string& name, double size) {
        color(name);
        setFont(context.get(), size);
        const std::string shown = drawableText(text);
        cairo_text_extents_t extents;
        cairo_text_extents(context.get(), shown.c_str(), &extents);
        const double share = anchor == Anchor::Start ? 0 : anchor == Anchor::Middle ? 0.5 : 1;
        cairo_rel_move_to(context.get(), -share * extents.x_advance, 0);
        cairo_show_text(context.get(), shown.c_str());
    }
};

Drawing::Drawing(Target target, double width, double height, const std::string& title) : impl_(std::make_unique<Impl>(target, width, height, title)) {}
Drawing::~Drawing() = default;

void Drawing::line(double x0, double y0, double x1, double y1, const std::string& color, double width, bool dashed) {
    constexpr double kDashes[] = {5, 4};
    cairo_t* const context = impl_->context.get();
    cairo_set_dash(context, kDashes, dashed ? 2 : 0, 0);
    // Thin lines along an axis fill whole rows of pixels.
    const auto sharp = [&](double a, double other) { return a == other && width == 1 ? std::floor(a) + 0.5 : a; };
    cairo_move_to(context, sharp(x0, x1), sharp(y0, y1));
    cairo_line_to(context, sharp(x1, x0), sharp(y1, y0));
    impl_->stroke(color, width);
    cairo_set_dash(context, nullptr, 0, 0);
}

void Drawing::path(std::span<const Point> points, const std::string& color, double width) {
    for (const auto& [x, y] : points)
        cairo_line_to(impl_->context.get(), x, y);
    impl_->stroke(color, width);
}

void Drawing::area(std::span<const Point> points, const std::string& color, double x0, double y0, double x1, double y1) {
    cairo_t* const context = impl_->context.get();
    cairo_save(context);
    cairo_rectangle(context, x0, y0, x1 - x0, y1 - y0);
    cairo_clip(context);
    for (const auto& [x, y] : points)
        cairo_line_to(context, x, y);
    impl_->color(color);
    cairo_fill(context);
    cairo_restore(context);
}

void Drawing::box(double x0, double y0, double x1, double y1, const std::string& color) {
    line(x0, y0, x1, y0, color);
    line(x0, y1, x1, y1, color);
    line(x0, y0, x0, y1, color);
    line(x1, y0, x1, y1, color);
}

void Drawing::circle(double x, double y, double radius, const std::string& color, bool filled) {
    cairo_t* const context = impl_->context.get();
    cairo_new_path(context);
    cairo_arc(context, x, y, radius, 0, 2 * M_PI);
    impl_->color(filled ? color : "#ffffff");
    cairo_fill_preserve(context);
    impl_->stroke(color, 1.2);
}

void Drawing::text(double x, double baseline, const std::string& text, Anchor anchor, const std::string& color, double size) {
    cairo_move_to(impl_->context.get(), x, baseline);
    impl_->letters(text, anchor, color, size);
    cairo_new_path(impl_->context.get());
}

void Drawing::label(double x, double top, const std::string& text, const std::string& color, double size) {
    this->text(x, top + capitals(size), text, Anchor::Start, color, size);
}

void Drawing::upwards(double baseline, double middle, const std::string& text) {
    cairo_t* const context = impl_->context.get();
    cairo_save(context);
    cairo_translate(context, baseline, middle);
    cairo_rotate(context, -M_PI / 2);
    cairo_move_to(context, 0, 0);
    impl_->letters(text, Anchor::Middle, "#000000", 12);
    cairo_restore(context);
    cairo_new_path(context);
}

void Drawing::image(int x, int y, int width, int height, const Image& image) {
    const Image fitted = fittedImage(image, width, height);
    const CairoSurface pixels(cairo_image_surface_create(CAIRO_FORMAT_RGB24, fitted.width, fitted.height));
    unsigned char* const data = cairo_image_surface_get_data(pixels.get());
    for (int j = 0; j < fitted.height; ++j)
        for (int i = 0; i < fitted.width; ++i) {
            const float* const value = fitted.at(i, j);
            const std::uint32_t rgb = std::uint32_t(pngCode(value[0])) << 16 | std::uint32_t(pngCode(value[1])) << 8 | pngCode(value[2]);
            std::memcpy(data + std::ptrdiff_t(j) * cairo_image_surface_get_stride(pixels.get()) + 4 * i, &rgb, sizeof rgb);
        }
    cairo_surface_mark_dirty(pixels.get());
    cairo_t* const context = impl_->context.get();
    const int left = x + (width - fitted.width) / 2;
    cairo_set_source_surface(context, pixels.get(), left, y);
    cairo_rectangle(context, left, y, fitted.width, fitted.height);
    cairo_fill(context);
}

int Drawing::textWidth(const std::string& text, double size) {
    const CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
    const CairoContext context(cairo_create(surface.get()));
    setFont(context.get(), size);
    cairo_text_extents_t extents;
    cairo_text_extents(context.get(), drawableText(text).c_str(), &extents);
    return int(std::ceil(extents.x_advance));
}

int Drawing::capitals(double size) {
    return int(std::lround(0.7 * size));
}

std::string Drawing::svg() {
    impl_->context.reset();
    cairo_surface_finish(impl_->surface.get());
    std::string& text = impl_->written;
    if (const std::size_t tag = text.find("<svg"), end = text.find('>', tag); end != std::string::npos && !impl_->title.empty())
        text.insert(end + 1, "\n<title>" + escapeHtml(impl_->title) + "</title>");
    return std::move(text);
}

Image Drawing::picture() {
    cairo_surface_t* const surface = impl_->surface.get();
    cairo_surface_flush(surface);
    Image image(cairo_image_surface_get_width(surface), cairo_image_surface_get_height(surface), 3);
    const unsigned char* const data = cairo_image_surface_get_data(surface);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            std::uint32_t rgb = 0;
            std::memcpy(&rgb, data + std::ptrdiff_t(y) * cairo_image_surface_get_stride(surface) + 4 * x, sizeof rgb);
            for (int c = 0; c < 3; ++c)
                image.at(x, y)[c] = srgbDecode(float(rgb >> (16 - 8 * c) & 255) / 255);
        }
    return image;
}

} // namespace cmpg
