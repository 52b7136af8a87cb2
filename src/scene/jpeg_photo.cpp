// What a JPEG file of a camera says beside its pixels.
#include "scene/jpeg_photo.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cmpg {
namespace {

using File = std::span<const std::uint8_t>;

// Numbers of a TIFF file, which says itself in which order its bytes are (TIFF 6.0, section 2). Beyond its end there are zeros.
class Tiff {
  public:
    explicit Tiff(File bytes) : bytes_(bytes), big_(at(0) == 'M') {}

    std::uint32_t number(std::size_t offset, std::size_t bytes) const {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < bytes; ++i)
            value = value << 8 | at(offset + (big_ ? i : bytes - 1 - i));
        return value;
    }

    int orientation() const {
        constexpr std::size_t kEntryBytes = 12;
        constexpr std::uint32_t kOrientation = 0x0112, kShort = 3;
        if (at(0) != at(1) || (at(0) != 'M' && at(0) != 'I') || number(2, 2) != 42)
            return 1;
        const std::size_t directory = number(4, 4);
        const std::uint32_t entries = number(directory, 2);
        for (std::size_t i = 0; i < entries; ++i) {
            const std::size_t entry = directory + 2 + i * kEntryBytes;
            if (entry + kEntryBytes > bytes_.size())
                return 1;
            if (number(entry, 2) == kOrientation && number(entry + 2, 2) == kShort && number(entry + 4, 4) == 1) {
                const std::uint32_t value = number(entry + 8, 2);
                return value >= 1 && value <= 8 ? int(value) : 1;
            }
        }
        return 1;
    }

  private:
    std::uint8_t at(std::size_t i) const { return i < bytes_.size() ? bytes_[i] : 0; }

    File bytes_;
    bool big_;
};

// Of an array with `channels` values per pixel of width x height pixels.
template <class T> std::vector<T> turned(const std::vector<T>& from, std::size_t width, std::size_t height, std::size_t channels, int orientation) {
    if (from.empty())
        return from;
    const bool transposed = orientation >= 5, mirroredX = orientation == 2 || orientation == 3 || orientation >= 7,
               mirroredY = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    std::vector<T> to(from.size());
    auto next = to.begin();
    for (std::size_t y = 0; y < (transposed ? width : height); ++y)
        for (std::size_t x = 0; x < (transposed ? height : width); ++x) {
            const std::size_t column = transposed ? y : x, row = transposed ? x : y; // as stored, but for mirrors
            const std::size_t place = (mirroredY ? height - 1 - row : row) * width + (mirroredX ? width - 1 - column : column);
            next = std::copy_n(from.begin() + std::ptrdiff_t(place * channels), channels, next);
        }
    return to;
}

} // namespace

bool isJpeg(File file) { return file.size() >= 3 && file[0] == 0xff && file[1] == 0xd8 && file[2] == 0xff; }

int exifOrientation(File jpeg) {
    constexpr std::uint8_t kApplication = 0xe1, kScan = 0xda;
    constexpr std::array<std::uint8_t, 6> kExif{'E', 'x', 'i', 'f', 0, 0};
    for (std::size_t at = 2; at + 4 <= jpeg.size() && jpeg[at] == 0xff && jpeg[at + 1] != kScan;) {
        const std::size_t length = std::size_t(jpeg[at + 2]) << 8 | jpeg[at + 3];
        if (length < 2 || length > jpeg.size() - at - 2)
            return 1;
        const File content = jpeg.subspan(at + 4, length - 2);
        if (jpeg[at + 1] == kApplication && content.size() > kExif.size() && std::equal(kExif.begin(), kExif.end(), content.begin()))
            return Tiff(content.subspan(kExif.size())).orientation();
        at += 2 + length;
    }
    return 1;
}

ReadImage upright(ReadImage image, int orientation) {
    if (orientation <= 1)
        return image;
    const auto width = std::size_t(image.image.width), height = std::size_t(image.image.height), channels = std::size_t(image.image.channels);
    image.image.values = turned(image.image.values, width, height, channels, orientation);
    image.alpha = turned(image.alpha, width, height, 1, orientation);
    image.clipped = turned(image.clipped, width, height, channels, orientation);
    if (orientation >= 5)
        std::swap(image.image.width, image.image.height);
    return image;
}

std::vector<std::uint8_t> clippedBeforeCompression(File bytes, std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
    constexpr std::uint32_t kBlock = 16;
    constexpr std::uint8_t kNearest = 250, kFurthest = 224;
    std::vector<std::uint8_t> clipped(bytes.size());
    const auto place = [&](std::uint32_t x, std::uint32_t y, std::uint32_t c) { return (std::size_t(y) * width + x) * channels + c; };
    for (std::uint32_t top = 0; top < height; top += kBlock)
        for (std::uint32_t left = 0; left < width; left += kBlock)
            for (std::uint32_t c = 0; c < channels; ++c) {
                const std::uint32_t bottom = std::min(top + kBlock, height), right = std::min(left + kBlock, width);
                std::uint8_t largest = 0;
                for (std::uint32_t y = top; y < bottom; ++y)
                    for (std::uint32_t x = left; x < right; ++x)
                        largest = std::max(largest, bytes[place(x, y, c)]);
                if (largest < kNearest)
                    continue;
                for (std::uint32_t y = top; y < bottom; ++y)
                    for (std::uint32_t x = left; x < right; ++x)
                        clipped[place(x, y, c)] = bytes[place(x, y, c)] >= kFurthest;
            }
    return clipped;
}

} // namespace cmpg
