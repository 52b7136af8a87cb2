// Cairo's text as pictures and plots draw it.
#include "imaging/cairo_text.h"

#include <algorithm>

namespace cmpg {

void setFont(cairo_t* context, double size) {
    cairo_select_font_face(context, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context, size);
    const std::unique_ptr<cairo_font_options_t, CairoDestroy> options(cairo_font_options_create());
    cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_FULL);
    cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_ON);
    cairo_set_font_options(context, options.get());
}

std::string drawableText(std::string_view text) {
    std::string result(text);
    std::replace_if(result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    const CairoSurface surface(cairo_image_surface_create(CAIRO_FORMAT_A8, 1, 1));
    const CairoContext context(cairo_create(surface.get()));
    cairo_text_extents_t ignored;
    cairo_text_extents(context.get(), result.c_str(), &ignored);
    if (cairo_status(context.get()) != CAIRO_STATUS_SUCCESS)
        std::replace_if(result.begin(), result.end(), [](unsigned char c) { return c >= 0x80; }, '?');
    return result;
}

} // namespace cmpg
