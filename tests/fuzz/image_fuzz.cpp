// .exr, .hdr, .png and .jpg files.
#include "fuzz.h"
#include "scene/image.h"

#include <cmath>

using namespace cmpg;

// Larger ones are refused, so that what is allocated for a small file shows.
constexpr std::size_t kMaxPixels = std::size_t(1) << 22;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::MemoryFile file;
    const std::string& path = file.holding({data, size});
    const bool linear = size % 2 == 0; // both are reached by inputs that are otherwise alike
    fuzz::accepts({ErrorKind::Input}, [&] {
        const ReadImage read = readImage(path, {.linear = linear, .maxPixels = kMaxPixels});
        const Image& image = read.image;
        fuzz::require(image.width > 0 && image.height > 0 && image.pixels() <= kMaxPixels, "images have a size within the limits");
        fuzz::require(image.values.size() == image.pixels() * std::size_t(image.channels), "every pixel has its channels");
        for (const float v : image.values)
            fuzz::require(std::isfinite(v), "values are finite");
        for (const float a : read.alpha)
            fuzz::require(std::isfinite(a), "alpha is finite");
    });
    fuzz::accepts({ErrorKind::Input}, [&] { readImage(path, {.linear = linear, .finite = false, .maxPixels = kMaxPixels, .layer = "normal"}); });
    return 0;
}
