// A float image in host memory and its files.
#pragma once

#include <cmpg/namespace.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace cmpg {

// Row-major, channels interleaved, row 0 on top, linear values.
struct Image {
    int width = 0, height = 0, channels = 3;
    std::vector<float> values;

    Image() = default;
    Image(int w, int h, int c, float fill = 0) : width(w), height(h), channels(c), values(std::size_t(w) * h * c, fill) {}
    float* at(int x, int y) { return values.data() + (std::size_t(y) * width + x) * channels; }
    const float* at(int x, int y) const { return values.data() + (std::size_t(y) * width + x) * channels; }
    std::size_t pixels() const { return std::size_t(width) * height; }
};

} // namespace cmpg

namespace cmpg::v1 {

// Reads .exr, .hdr, .png or .jpg by content, as 3 channels; .png and .jpg are decoded from sRGB. Error(Input) on anything malformed, or larger than
// 2^28 pixels.
Image loadImage(const std::filesystem::path& file);

// By the file's ending: .exr has the exact values (32-bit floats; one channel is written three times), .png 8-bit sRGB of values times
// 2^exposure, clamped to [0,1]. Written aside and renamed. Error(Usage) on another ending, Error(Output) where it cannot be written.
void saveImage(const std::filesystem::path& file, const Image& image, float exposure = 0);

// The bytes of such a PNG file.
std::vector<std::uint8_t> encodePng(const Image& image, float exposure = 0);

} // namespace cmpg::v1
