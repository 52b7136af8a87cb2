// Pictures of what one cell of a guide would draw from.
#include "imaging/guide_maps.h"

#include "imaging/display_image.h"
#include "imaging/drawing.h"
#include "imaging/number_text.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr int kEdge = 256, kMapMargin = 12, kAxis = 14, kMapTitle = 34, kMapCaption = 16, kLegend = 30;
constexpr double kDecades = 4; // between the brightest colour and the darkest; what is less is as dark

template <class Colors> Image colored(const Image& values, Colors&& colors) {
    Image result(values.width, values.height, 3);
    for (std::size_t p = 0; p < values.pixels(); ++p) {
        const Color color = colors(double(values.values[p]));
        std::copy(color.begin(), color.end(), result.values.begin() + std::ptrdiff_t(3 * p));
    }
    return result;
}

void drawMap(Drawing& drawing, int x, int y, const std::string& caption, const Image& map) {
    drawing.label(x, y, caption);
    y += kMapCaption;
    const double high = double(*std::max_element(map.values.begin(), map.values.end()));
    drawing.image(x, y, kEdge, kEdge, colored(map, [&](double density) {
                      return density > 0 ? heatColor(1 + std::log10(density / high) / kDecades) : kBlack;
                  }));
    // The map's axes at its corners, then the scale.
    const std::string ink = "#464646";
    drawing.label(x - kAxis, y, "+z", ink);
    drawing.label(x - kAxis, y + kEdge - Drawing::capitals(), "-z", ink);
    y += kEdge + 4;
    const std::string turn = "2 pi";
    drawing.label(x, y, "0", ink);
    drawing.label(x + (kEdge - Drawing::textWidth("azimuth")) / 2, y, "azimuth", ink);
    drawing.label(x + kEdge - Drawing::textWidth(turn), y, turn, ink);
    y += kAxis;
    if (high == 0) {
        drawing.label(x, y, "nothing known");
        return;
    }
    Image scale(kEdge, 10, 1);
    for (std::size_t p = 0; p < scale.pixels(); ++p)
        scale.values[p] = (float(p % kEdge) + 0.5f) / kEdge;
    drawing.image(x, y, kEdge, 10, colored(scale, heatColor));
    const std::string least = threeDigits(high * std::pow(10.0, -kDecades)), most = threeDigits(high);
    drawing.label(x, y + 14, least);
    drawing.label(x + (kEdge - Drawing::textWidth("log, black: 0")) / 2, y + 14, "log, black: 0", ink);
    drawing.label(x + kEdge - Drawing::textWidth(most), y + 14, most);
}

} // namespace

Image drawCell(const DrawnCell& cell) {
    constexpr int kStride = kAxis + kEdge + kMapMargin;
    Drawing drawing(Drawing::Target::Picture, kMapMargin + 4 * kStride, kMapTitle + kMapCaption + kEdge + kAxis + kLegend + kMapMargin);
    drawing.label(kMapMargin, kMapMargin / 2,
                "cell " + std::to_string(cell.number) + ", " + threeDigits(cell.weight) + " records: density over that of uniform directions",
                "#000000", 20);
    const auto [wL, wD] = cell.weights;
    struct Panel {
        std::string caption;
        std::array<double, 3> weights;
    };
    const Panel panels[] = {{"P, mean " + threeDigits(cell.means[0]), {1, 0, 0}},
                            {"D+, mean " + threeDigits(cell.means[1]), {0, 1, 0}},
                            {"D-, mean " + threeDigits(cell.means[2]), {0, 0, 1}},
                            {threeDigits(wL) + " P + " + threeDigits(wD) + " D", {wL, wD, wD}}};
    int x = kMapMargin + kAxis;
    for (const Panel& panel : panels) {
        drawMap(drawing, x, kMapTitle, panel.caption, cell.density(panel.weights, kEdge));
        x += kStride;
    }
    return drawing.picture();
}

} // namespace cmpg
