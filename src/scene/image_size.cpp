// The size of an image that a camera takes.
#include "scene/image_size.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

std::optional<double> aspectOf(const Camera& camera) {
    if (camera.size)
        return double(camera.size->x) / camera.size->y;
    return camera.aspect;
}

std::pair<int, int> imageSize(const Camera& camera, std::optional<std::uint32_t> width, std::optional<std::uint32_t> height, int defaultWidth) {
    const double aspect = aspectOf(camera).value_or(1);
    if (camera.size && !width && !height) {
        width = camera.size->x;
        height = camera.size->y;
    }
    const auto edge = [](double length) { return int(std::lround(std::clamp(length, 1.0, 32768.0))); };
    std::pair<int, int> size;
    if (width || !height) {
        size.first = int(width.value_or(std::uint32_t(defaultWidth)));
        size.second = height ? int(*height) : edge(size.first / aspect);
    } else {
        size.second = int(*height);
        size.first = edge(size.second * aspect);
    }
    constexpr std::uint64_t kMostPixels = std::uint64_t(1) << 28;
    const std::uint64_t pixels = std::uint64_t(size.first) * std::uint64_t(size.second);
    if (pixels > kMostPixels)
        throw Error(ErrorKind::Usage,
                    "an image of " + std::to_string(size.first) + "x" + std::to_string(size.second) + " is larger than " +
                        std::to_string(kMostPixels >> 20) + " million pixels",
                    "its floats alone would take " + std::to_string((pixels * 12) >> 30) + " GiB of host memory", "lower its size", {"width", "height"});
    return size;
}

} // namespace cmpg
