// Image files in memory: decoding to texels as stored, sizes checked from the header before anything is allocated; encoding.
#pragma once

#include "scene/file_io.h"
#include "scene/image.h"

#include <functional>
#include <string>

namespace cmpg {

// What a file holds. Exactly one of the arrays is filled; channels interleaved, row 0 on top.
struct RawImage {
    std::uint32_t width = 0, height = 0, channels = 0; // 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
    Bytes bytes;               // 8-bit files
    std::vector<float> values; // 16-bit PNG: code / 65535; .exr and .hdr: linear values
    bool linear = false;       // values need no sRGB decoding whatever their use: .exr and .hdr

    std::size_t pixels() const { return std::size_t(width) * height; }
    bool hasAlpha() const { return channels == 2 || channels == 4; }
    // The stored channel that plays red (0), green (1), blue (2) or alpha (3; only if hasAlpha()).
    std::uint32_t channel(std::uint32_t rgba) const {
        if (rgba == 3) return channels - 1;
        return channels <= 2 ? 0 : rgba;
    }
};

struct ImageLimits {
    std::size_t maxEdge = 65536;
    std::size_t maxPixels = std::size_t(1) << 28;
    std::string layer = {}; // of an EXR file with several: read `layer`.R or .X and so on
    bool finite = true;     // refuse values that are not
};

// Reads .exr .hdr .png .jpg by content; `name` stands in messages. Throws Error(Input) on anything malformed or too large.
RawImage decodeImage(std::span<const std::uint8_t> file, const std::string& name, const ImageLimits& limits = {});

// The .hdr part of it: throws std::runtime_error if malformed, and calls `checkSize` (width, height) before allocating.
RawImage decodeHdr(std::span<const std::uint8_t> file, const std::function<void(std::uint64_t, std::uint64_t)>& checkSize);

// The bytes that writeExr() and writePng() put into a file, and a PNG file of 8-bit texels. Throw Error(Output).
Bytes encodeExr(const Image& image);
Bytes encodePng(const Image& image);
std::uint8_t pngCode(float linear); // of one value; what is not a number becomes 0
Bytes encodePng(std::span<const std::uint8_t> pixels, int width, int height, int channels);

// The 256 linear values of 8-bit sRGB codes.
const float* srgbTable();

} // namespace cmpg
