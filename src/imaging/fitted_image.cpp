// An image as large as a panel.
#include "imaging/fitted_image.h"

#include "imaging/color.h"

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

FittedSize fittedSize(const Image& image, int width, int height) {
    double scale = std::min(double(width) / image.width, double(height) / image.height);
    if (scale > 1)
        scale = std::floor(scale); // whole blocks, so that pixels stay visible as such
    return {std::max(1, int(image.width * scale)), std::max(1, int(image.height * scale))};
}

Image fittedImage(const Image& image, int width, int height) {
    const auto [w, h] = fittedSize(image, width, height);
    Image result(w, h, 3);
    for (int j = 0; j < h; ++j)
        for (int i = 0; i < w; ++i) {
            const Color mean = boxMean(image, double(i) * image.width / w, double(j) * image.height / h, double(i + 1) * image.width / w,
                                       double(j + 1) * image.height / h);
            std::copy(mean.begin(), mean.end(), result.at(i, j));
        }
    return result;
}

} // namespace cmpg
