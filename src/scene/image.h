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
    bool eightBit = false;  // decoded from 8-bit sRGB; values at 0 or 255 may be clipped
    std::vector<std::uint8_t> clipped; // eightBit: 1 for values at 255
};

// Reads .exr .hdr .png .jpg by content. 8-bit files are sRGB-decoded unless `linear`. Throws Error(Input) on anything malformed
// or larger than `maxPixels`. `layer`: of an EXR file with several.
ReadImage readImage(const std::filesystem::path& file, bool linear = false, std::size_t maxPixels = std::size_t(1) << 28,
                    const std::string& layer = {});

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
