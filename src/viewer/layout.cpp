// Which pictures a mode shows, and how they share the window.
#include "viewer/layout.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {

std::vector<LivePicture> picturesOf(LiveMode mode, bool layers) {
    using P = LivePicture;
    std::vector<P> pictures{P::Image};
    if (mode == LiveMode::Gradient)
        pictures.push_back(P::Gradient);
    if (mode == LiveMode::Optimize)
        pictures = {P::Image, P::Target, P::Difference, P::Gradient, P::Parameter, P::ParameterGradient};
    if (layers)
        pictures.insert(pictures.end(), {P::Normal, P::Depth, P::Albedo, P::Guided, P::Cells});
    return pictures;
}

Group groupOf(LivePicture picture) {
    return picture == LivePicture::Parameter || picture == LivePicture::ParameterGradient ? Group::Parameter : Group::Image;
}

std::vector<Rectangle> tiles(const Rectangle& area, std::size_t count, float aspect, float border, float gap) {
    int best = 1;
    float most = -1;
    for (int columns = 1; columns <= int(count); ++columns) {
        const int rows = (int(count) + columns - 1) / columns;
        const float width = (area.width - gap * float(columns - 1)) / float(columns);
        const float height = (area.height - gap * float(rows - 1)) / float(rows) - border;
        const float size = std::min(width, height * aspect);
        if (size > most) {
            most = size;
            best = columns;
        }
    }
    const int rows = (int(count) + best - 1) / best;
    const float width = std::floor((area.width - gap * float(best - 1)) / float(best));
    const float height = std::floor((area.height - gap * float(rows - 1)) / float(rows));
    std::vector<Rectangle> result;
    result.reserve(count);
    for (int i = 0; i < int(count); ++i) {
        const int row = i / best, column = i % best;
        result.push_back({area.x + float(column) * (width + gap), area.y + float(row) * (height + gap), std::max(1.f, width), std::max(1.f, height)});
    }
    return result;
}

} // namespace cmpg::viewer
