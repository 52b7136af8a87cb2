// What a JPEG file of a camera says beside its pixels.
#pragma once

#include "scene/image.h"

#include <cstdint>
#include <span>

namespace cmpg {

bool isJpeg(std::span<const std::uint8_t> file);

// EXIF's orientation (tag 0x0112 of its first directory), from 1 to 8; 1, as stored, where there is none or it cannot be read.
int exifOrientation(std::span<const std::uint8_t> jpeg);

// Turns and mirrors an image that is stored by an orientation into the one that viewers show.
ReadImage upright(ReadImage image, int orientation);

// By value of a decoded 8-bit JPEG, `channels` interleaved: 1 where it may have been clipped before it was compressed. Compression takes clipped values below 255, so
// this is said of all from 224 on in blocks of 16 x 16 pixels, the largest that JPEG codes as one, that have a value of the channel from 250 on: it leaves out 5 of 733 at
// most in pictures of a quality from 50 to 97.
std::vector<std::uint8_t> clippedBeforeCompression(std::span<const std::uint8_t> bytes, std::uint32_t width, std::uint32_t height, std::uint32_t channels);

} // namespace cmpg
