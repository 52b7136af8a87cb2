// Images of the library's surface and their files.
#include "base/error.h"
#include "scene/file_io.h"
#include "scene/image_decode.h"

#include <cmath>

namespace cmpg::v1 {
namespace {

Image threeChannels(const Image& image) {
    if (image.channels == 3)
        return image;
    if (image.channels != 1)
        throw Error(ErrorKind::Usage, "an image of " + std::to_string(image.channels) + " channels is neither grey nor RGB");
    Image color(image.width, image.height, 3);
    for (std::size_t i = 0; i < color.values.size(); ++i)
        color.values[i] = image.values[i / 3];
    return color;
}

void requireValues(const Image& image) {
    if (image.width < 1 || image.height < 1 || image.values.size() != image.pixels() * std::size_t(image.channels))
        throw Error(ErrorKind::Usage, "an image of " + std::to_string(image.width) + "x" + std::to_string(image.height) + "x" +
                                          std::to_string(image.channels) + " has " + std::to_string(image.values.size()) + " values");
}

} // namespace

Image loadImage(const std::filesystem::path& file) { return threeChannels(readImage(file).image); }

std::vector<std::uint8_t> encodePng(const Image& image, float exposure) {
    requireValues(image);
    Image exposed = threeChannels(image);
    const float scale = std::exp2(exposure);
    for (float& value : exposed.values)
        value *= scale;
    return cmpg::encodePng(exposed);
}

void saveImage(const std::filesystem::path& file, const Image& image, float exposure) {
    requireValues(image);
    const std::string extension = file.extension().string();
    if (extension == ".exr")
        writeFile(file, encodeExr(threeChannels(image)));
    else if (extension == ".png")
        writeFile(file, encodePng(image, exposure));
    else
        throw Error(ErrorKind::Usage, "'" + file.string() + "' is neither an EXR nor a PNG file", "", "end its name in .exr or .png");
}

} // namespace cmpg::v1
