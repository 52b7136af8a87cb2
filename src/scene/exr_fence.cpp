// What stands between .exr files and OpenEXR: the headers of all parts, read before the library reads them.
#include "base/byte_stream.h"
#include "scene/image_fence.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

namespace cmpg {
namespace {

using File = std::span<const std::uint8_t>;

// One part of an OpenEXR file, as its header says.
struct Part {
    double width = 0, height = 0;           // of the data window
    double shownWidth = 0, shownHeight = 0; // of the display window
    double pixelBytes = 0;                  // of all channels
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

// Of a pixel.
double channelBytes(ByteReader in) {
    constexpr std::uint32_t kHalf = 1;
    double bytes = 0;
    while (!nameIn(in).empty()) {
        bytes += in.get<std::uint32_t>() == kHalf ? 2 : 4;
        in.take(12); // linearity, sampling
    }
    in.end();
    return bytes;
}

// OpenEXR reads as many bytes as the type has, or as the value itself says, whatever its size in the header: they must agree, else it takes
// one thing for another. Types that are not here it reads by their size.
void checkValue(const std::string& type, File bytes) {
    constexpr std::pair<std::string_view, std::size_t> kSizes[] = {
        {"box2i", 16}, {"box2f", 16}, {"chromaticities", 32}, {"compression", 1}, {"deepImageState", 1}, {"double", 8}, {"envmap", 1}, {"float", 4},
        {"int", 4}, {"keycode", 28}, {"lineOrder", 1}, {"m33f", 36}, {"m33d", 72}, {"m44f", 64}, {"m44d", 128}, {"rational", 8},
        {"tiledesc", 9}, {"timecode", 8}, {"v2i", 8}, {"v2f", 8}, {"v2d", 16}, {"v3i", 12}, {"v3f", 12}, {"v3d", 24}};
    for (const auto& [name, size] : kSizes)
        if (type == name && bytes.size() != size)
            throw Malformed{"an attribute of its header has another size than its type"};
    ByteReader value(bytes);
    if (type == "chlist") {
        channelBytes(value);
    } else if (type == "preview") {
        const std::uint64_t width = value.get<std::uint32_t>(), height = value.get<std::uint32_t>();
        if (height > 0 && width > bytes.size() / height)
            throw Malformed{"its preview announces more than it holds"};
        value.take(std::size_t(4 * width * height));
        value.end();
    } else if (type == "stringvector") {
        while (!value.atEnd())
            value.take(value.get<std::uint32_t>());
    }
}

// From the name of its first attribute on. OpenEXR makes room for an attribute before it reads it, too.
Part readPart(ByteReader& in, std::string attribute, bool tiled) {
    Part part;
    part.tiled = tiled;
    for (; !attribute.empty(); attribute = nameIn(in)) {
        const std::string type = nameIn(in);
        const std::uint32_t size = in.get<std::uint32_t>();
        const File bytes = in.take(size);
        checkValue(type, bytes);
        ByteReader value(bytes);
        if (attribute == "dataWindow" || attribute == "displayWindow") {
            double edge[4]; // left, top, right, bottom
            for (double& e : edge)
                e = std::int32_t(value.get<std::uint32_t>());
            const bool data = attribute == "dataWindow";
            (data ? part.width : part.shownWidth) = edge[2] - edge[0] + 1;
            (data ? part.height : part.shownHeight) = edge[3] - edge[1] + 1;
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
    // What is shown beyond the data costs a file nothing, and takes up to four floats.
    const double shown = part.shownWidth * part.shownHeight;
    if (shown > part.width * part.height && 4 * sizeof(float) * shown > std::max(kFewBytes, held))
        throw Malformed{"its header announces a larger display window than a file of its size may have"};
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

} // namespace cmpg
