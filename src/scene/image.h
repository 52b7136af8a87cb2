// A float image in host memory and its files.
#pragma once

#include <cmpg/image.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace cmpg {

struct ReadImage {
    Image image;            // 1, 3 channels; linear
    std::vector<float> alpha; // empty when the file has none; else one value per pixel in [0,1]
    std::vector<std::uint8_t> clipped; // of .png and .jpg: 1 for values at the largest code, or so near to it that compression may have changed them; else empty
};

struct ReadOptions {
    bool linear = false; // .png and .jpg: values are not sRGB-decoded
    bool finite = true;  // NaN and infinities are refused
    std::size_t maxPixels = std::size_t(1) << 28;
    std::string layer = {}; // of an EXR file with several
};

// Reads .exr .hdr .png .jpg by content; the latter as their EXIF orientation says. Throws Error(Input) on anything malformed or too large.
ReadImage readImage(const std::filesystem::path& file, const ReadOptions& options = {});

// float32, ZIP, exactly R,G,B (one channel is written three times), no attribute that differs between equal runs.
// Written aside and renamed. Throws Error(Output).
void writeExr(const std::filesystem::path& file, const Image& image);
// Named layers: {"normal.X", ...}; every image one channel, same size.
void writeExrLayers(const std::filesystem::path& file, const std::vector<std::pair<std::string, Image>>& layers);
// 8-bit sRGB-encoded PNG of 3-channel values clamped to [0,1].
void writePng(const std::filesystem::path& file, const Image& image);

float srgbDecode(float encoded); // exact piecewise curve, [0,1] -> [0,1]
float srgbEncode(float linear);

} // namespace cmpg
