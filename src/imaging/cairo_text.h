// Cairo's objects, and its text as pictures and plots draw it.
#pragma once

#include <cairo/cairo.h>

#include <memory>
#include <string>
#include <string_view>

namespace cmpg {

struct CairoDestroy {
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
};
using CairoSurface = std::unique_ptr<cairo_surface_t, CairoDestroy>;
using CairoContext = std::unique_ptr<cairo_t, CairoDestroy>;

// The same on every machine, whatever its settings; strokes lie on rows of pixels.
void setFont(cairo_t* context, double size);
// What is no UTF-8 becomes '?', control characters do as well.
std::string drawableText(std::string_view text);

} // namespace cmpg
