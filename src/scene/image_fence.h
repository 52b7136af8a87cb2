// What stands between image files and the libraries that decode them: sizes that a file announces but cannot hold, and what
// OpenEXR 3.1 or stb_image 2.27 take for granted, are looked at before they allocate memory, or spend time, by them. Each throws Malformed.
#pragma once

#include <cstdint>
#include <span>

namespace cmpg {

// The headers of all parts, before the library sees the file.
void fenceExr(std::span<const std::uint8_t> file);

// .png and .jpg files whose header stb_image has read.
void fenceStb(std::span<const std::uint8_t> file, std::uint64_t width, std::uint64_t height);

void fenceHdr(std::span<const std::uint8_t> file, std::uint64_t width, std::uint64_t height);

} // namespace cmpg
