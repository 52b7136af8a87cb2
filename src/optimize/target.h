// A target image with the weight each of its pixels has in the loss.
#pragma once

#include "scene/image.h"

#include <functional>
#include <string>

namespace cmpg {

struct TargetOptions {
    std::filesystem::path mask; // image whose mean channel is a weight in [0,1]; empty: none
    float exposure = 0;         // the target is multiplied by 2^exposure
};

struct Target {
    std::string name; // file it came from, for messages
    Image image;      // 3 channels, linear
    std::vector<float> mask;   // weight per pixel in [0,1], or empty for 1 everywhere
    std::vector<std::uint8_t> clipped; // 1 for values at the largest code of a .png or .jpg file, which are lower bounds; or empty for none
    std::uint64_t invalid = 0; // pixels left out because they are not finite
    // Where the image has a size and no values: gives all of it, whenever a step needs it (LoadedTarget), and its digest.
    std::function<Target()> read{};
    std::string digest{};
};

// Reads .exr .hdr .png .jpg; 8-bit values are sRGB-decoded. Weights multiply: alpha of the file, `mask`, 0 for non-finite
// pixels. Error(Input) if nothing is left, or the mask has another size.
Target loadTarget(const std::filesystem::path& file, const TargetOptions& options = {});

// Error(Input) with both sizes and the remedy if the target cannot be compared with a width x height image.
void requireSize(const Target& target, int width, int height);

} // namespace cmpg
