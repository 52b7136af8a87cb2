// Zoom and pan: which part of a picture stands where in its panel.
#include "viewer/picture_view.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

constexpr double kLeastZoom = 0.25;
constexpr double kLargestPixel = 128; // in pixels of the window

double fitScale(int width, int height, const Rectangle& area) {
    return std::max(1e-3, std::min(double(area.width) / width, double(area.height) / height));
}

double scaleOf(const PictureView& view, int width, int height, const Rectangle& area) {
    const double scale = fitScale(width, height, area) * view.zoom, whole = std::round(scale);
    return whole >= 1 && std::abs(scale - whole) < 1e-3 * whole ? whole : scale;
}

} // namespace

Rectangle placeOf(const PictureView& view, int width, int height, const Rectangle& area) {
    const double scale = scaleOf(view, width, height, area);
    const double x = area.x + 0.5 * double(area.width) - view.center.x * width * scale;
    const double y = area.y + 0.5 * double(area.height) - view.center.y * height * scale;
    return {float(std::round(x)), float(std::round(y)), float(width * scale), float(height * scale)};
}

std::optional<glm::ivec2> pixelAt(glm::vec2 point, int width, int height, const Rectangle& place) {
    const glm::ivec2 pixel(int(std::floor((point.x - place.x) / place.width * float(width))),
                           int(std::floor((point.y - place.y) / place.height * float(height))));
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= width || pixel.y >= height)
        return std::nullopt;
    return pixel;
}

void zoomAbout(PictureView& view, double factor, glm::vec2 point, int width, int height, const Rectangle& area) {
    const double fit = fitScale(width, height, area);
    const double before = fit * view.zoom;
    view.zoom = std::clamp(view.zoom * factor, kLeastZoom, std::max(1.0, kLargestPixel / fit));
    const double after = fit * view.zoom;
    // What is under the point stays there.
    const glm::dvec2 away(double(point.x) - area.x - 0.5 * double(area.width), double(point.y) - area.y - 0.5 * double(area.height));
    view.center += away * (1 / before - 1 / after) / glm::dvec2(width, height);
    view.center = glm::clamp(view.center, 0.0, 1.0);
}

void panBy(PictureView& view, glm::vec2 distance, int width, int height, const Rectangle& area) {
    view.center -= glm::dvec2(distance) / scaleOf(view, width, height, area) / glm::dvec2(width, height);
    view.center = glm::clamp(view.center, 0.0, 1.0);
}

void showActualSize(PictureView& view, int width, int height, const Rectangle& area) {
    view.zoom = 1 / fitScale(width, height, area);
    view.center = {0.5, 0.5};
}

} // namespace cmpg::viewer
