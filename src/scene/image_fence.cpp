// What stands between image files and the libraries that decode them.
#include "scene/image_fence.h"

#include "base/byte_stream.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace cmpg {
namespace {

using File = std::span<const std::uint8_t>;

// Pixels that one byte of a file can stand for. Deflate makes at most 1032 bytes of one, and each may hold 8 pixels; a block of 8 x 8 pixels
// of a JPEG takes a bit, two components without a common sampling may share its pixels; four runs of 127 bytes take 8 bytes of an .hdr.
constexpr std::uint64_t kDensestPng = 8 * 1032, kDensestJpeg = 2 * 8 * 64, kDensestHdr = 16;

// Pixels times scans of a JPEG: the decoder visits every pixel in each, however little there is of it.
constexpr std::uint64_t kMaxJpegVisits = std::uint64_t(1) << 32;

void requireHeld(File file, std::uint64_t width, std::uint64_t height, std::uint64_t densest) {
    if (double(width) * double(height) > double(file.size()) * double(densest))
        throw Malformed{"its header announces more pixels than a file of its size can hold"};
}

// stb_image makes room for a chunk before it reads it.
void checkPngChunks(File file) {
    for (std::size_t at = 8; file.size() - at >= 8;) {
        std::uint64_t length = 0;
        for (std::size_t i = 0; i < 4; ++i)
            length = length << 8 | file[at + i];
        at += 8;
        if (length > file.size() - at)
            throw Malformed{"a chunk reaches beyond its end"};
        at = std::min<std::size_t>(at + std::size_t(length) + 4, file.size()); // 4: its checksum
    }
}

std::uint64_t jpegScans(File file) {
    std::uint64_t scans = 0;
    for (std::size_t i = 0; i + 1 < file.size(); ++i)
        scans += file[i] == 0xff && file[i + 1] == 0xda; // in a scan 0xff is followed by 0
    return scans;
}

// One part of an OpenEXR file, as its header says.
struct Part {
    double width = 0, height = 0;
    double pixelBytes = 0; // of all channels
    std::uint32_t compression = 0;
    double tileWidth = 0, tileHeight = 0;
    bool tiled = false;
};

constexpr std::uint32_t kTiled = 0x200, kDeep = 0x800, kSeveralParts = 0x1000; // flags beside the version

// Text up to a zero byte.
std::string nameIn(ByteReader& in) {
    std::string text;
    while (const std::uint8_t c = in.get<std::uint8_t>())
        text += char(c);
    return text;
}

double channelBytes(ByteReader in) {
    constexpr std::uint32_t kHalf = 1;
    double bytes = 0;
    while (!nameIn(in).empty()) {
        bytes += in.get<std::uint32_t>() == kHalf ? 2 : 4;
        in.take(12); // linearity, sampling
    }
    return bytes;
}

// From the name of its first attribute on. OpenEXR makes room for an attribute before it reads it, too.
Part readPart(ByteReader& in, std::string attribute, bool tiled) {
    Part part;
    part.tiled = tiled;
    for (; !attribute.empty(); attribute = nameIn(in)) {
        const std::string type = nameIn(in);
        const std::uint32_t size = in.get<std::uint32_t>();
        const File bytes = in.take(size);
        ByteReader value(bytes);
        if (attribute == "dataWindow") {
            double edge[4]; // left, top, right, bottom
            for (double& e : edge)
                e = std::int32_t(value.get<std::uint32_t>());
            part.width = edge[2] - edge[0] + 1;
            part.height = edge[3] - edge[1] + 1;
        } else if (attribute == "channels") {
            part.pixelBytes = channelBytes(value);
        } else if (attribute == "compression") {
            part.compression = value.get<std::uint8_t>();
        } else if (attribute == "tiles") {
            part.tileWidth = value.get<std::uint32_t>();
            part.tileHeight = value.get<std::uint32_t>();
        } else if (attribute == "type") {
            const std::string kind(bytes.begin(), bytes.end());
            part.tiled |= kind == "tiledimage";
            if (kind.starts_with("deep"))
                throw Malformed{"it has several samples per pixel, which is not supported"};
        }
    }
    return part;
}

void checkPart(const Part& part, double fileBytes) {
    // By compression: lines of a chunk, and bytes that one byte can stand for (ZIP: deflate's 1032, of subsampled channels; DWA packs runs
    // before it deflates them).
    constexpr std::uint32_t kLines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256}, kDwa = 8;
    constexpr double kDensest = 4096, kDensestDwa = 1 << 17;
    constexpr double kFewBytes = 1 << 26; // that may be allocated for any file
    if (part.compression >= std::size(kLines))
        throw Malformed{"its compression is unknown"};
    if (!(part.width > 0 && part.height > 0))
        throw Malformed{"it has no pixels"};
    if (part.tiled && !(part.tileWidth > 0 && part.tileHeight > 0))
        throw Malformed{"its tiles have no size"};
    const double chunkWidth = part.tiled ? part.tileWidth : part.width, chunkHeight = part.tiled ? part.tileHeight : kLines[part.compression];
    const double chunks = std::ceil(part.width / chunkWidth) * std::ceil(part.height / chunkHeight);
    if (8 * chunks > fileBytes) // each has its place in a table
        throw Malformed{"its header announces more lines or tiles than a file of its size can hold"};
    const double held = fileBytes * (part.compression < kDwa ? kDensest : kDensestDwa);
    if (part.width * part.height * part.pixelBytes > held)
        throw Malformed{"its header announces more pixels than a file of its size can hold"};
    // OpenEXR keeps a chunk, of tiled files a row of them.
    const double kept = std::max(part.width, chunkWidth) * std::min(chunkHeight, part.tiled ? chunkHeight : part.height) * part.pixelBytes;
    if (kept > std::max(kFewBytes, held))
        throw Malformed{"its header announces lines or tiles that a file of its size cannot hold"};
}

} // namespace

void fenceExr(File file) {
    ByteReader in(file);
    in.take(4); // magic
    const std::uint32_t version = in.get<std::uint32_t>();
    if (version & kDeep)
        throw Malformed{"it has several samples per pixel, which is not supported"};
    std::string attribute = nameIn(in);
    do {
        checkPart(readPart(in, attribute, (version & kTiled) != 0), double(file.size()));
    } while ((version & kSeveralParts) && !(attribute = nameIn(in)).empty());
}

void fenceStb(File file, std::uint64_t width, std::uint64_t height) {
    const bool png = file[0] == 0x89;
    requireHeld(file, width, height, png ? kDensestPng : kDensestJpeg);
    if (png)
        checkPngChunks(file);
    else if (jpegScans(file) > kMaxJpegVisits / (width * height))
        throw Malformed{"it comes in too many scans"};
}

void fenceHdr(File file, std::uint64_t width, std::uint64_t height) { requireHeld(file, width, height, kDensestHdr); }

} // namespace cmpg
