// What stands between .png, .jpg and .hdr files and their decoders.
#include "scene/image_fence.h"

#include "base/byte_stream.h"

#include <algorithm>
#include <array>
#include <vector>

namespace cmpg {
namespace {

using File = std::span<const std::uint8_t>;

// Pixels that one byte of a file can stand for. Deflate makes at most 1032 bytes of one, and each may hold 8 pixels; a block of 8 x 8 pixels
// of a JPEG takes a bit, two components without a common sampling may share its pixels; four runs of 127 bytes take 8 bytes of an .hdr.
constexpr std::uint64_t kDensestPng = 8 * 1032, kDensestJpeg = 2 * 8 * 64, kDensestHdr = 16;

// Pixels times scans of a JPEG: the decoder visits every pixel in each, however little there is of it.
constexpr std::uint64_t kMaxJpegVisits = std::uint64_t(1) << 30;

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

// The segments of a JPEG (ITU T.81, annex B). stb_image decodes with tables that were never defined, whatever memory held, and writes
// beyond its Huffman tables where one has more than 256 symbols.
class JpegSegments {
  public:
    explicit JpegSegments(File file) : file_(file) {}

    // Checks them all. Returns how many scans there are.
    std::uint64_t check() {
        constexpr std::uint8_t kEnd = 0xd9, kScan = 0xda;
        std::uint64_t scans = 0;
        for (std::size_t at = 2;;) {
            while (at + 1 < file_.size() && file_[at] == 0xff && file_[at + 1] == 0xff)
                ++at; // fills
            if (file_.size() - at < 4)
                return scans; // the decoder tells what is missing
            const std::uint8_t marker = file_[at + 1];
            if (file_[at] != 0xff || marker == 0 || isRestart(marker))
                throw Malformed{"there is something else between its segments"};
            if (marker == kEnd)
                return scans;
            const std::size_t length = std::size_t(file_[at + 2]) * 256 + file_[at + 3];
            if (length < 2 || length > file_.size() - at - 2)
                throw Malformed{"a segment reaches beyond its end"};
            readSegment(marker, ByteReader(file_.subspan(at + 4, length - 2)));
            at += 2 + length;
            if (marker != kScan)
                continue;
            ++scans;
            while (at + 1 < file_.size() && (file_[at] != 0xff || file_[at + 1] == 0 || isRestart(file_[at + 1])))
                ++at;
        }
    }

  private:
    struct Component {
        std::uint8_t id, quantisation;
    };

    static bool isRestart(std::uint8_t marker) { return marker >= 0xd0 && marker <= 0xd7; }
    static void require(bool holds, const char* otherwise) {
        if (!holds)
            throw Malformed{otherwise};
    }

    void readSegment(std::uint8_t marker, ByteReader in) {
        if (marker == 0xc4)
            readHuffmanTables(in);
        else if (marker == 0xdb)
            readQuantisation(in);
        else if (marker >= 0xc0 && marker <= 0xc2)
            readFrame(in, marker == 0xc2);
        else if (marker == 0xda)
            readScan(in);
    }

    void readHuffmanTables(ByteReader& in) {
        while (!in.atEnd()) {
            const auto which = in.get<std::uint8_t>(); // direct or alternating, number
            std::size_t symbols = 0;
            for (int length = 1; length <= 16; ++length)
                symbols += in.get<std::uint8_t>();
            require(symbols <= 256, "a Huffman table has more than 256 symbols");
            in.take(symbols);
            huffman_[which >> 4 & 1][which & 3] = true;
        }
    }

    void readQuantisation(ByteReader& in) {
        while (!in.atEnd()) {
            const auto which = in.get<std::uint8_t>(); // precision, number
            in.take(which >> 4 ? 128 : 64);
            quantisation_[which & 3] = true;
        }
    }

    void readFrame(ByteReader& in, bool progressive) {
        progressive_ = progressive;
        in.take(5); // precision, size
        components_.clear();
        for (std::uint32_t n = in.get<std::uint8_t>(); n > 0; --n) {
            const auto id = in.get<std::uint8_t>();
            in.take(1); // sampling
            components_.push_back({id, in.get<std::uint8_t>()});
        }
    }

    void readScan(ByteReader& in) {
        const std::uint32_t n = in.get<std::uint8_t>();
        std::vector<std::uint8_t> tables;
        for (std::uint32_t i = 0; i < n; ++i) {
            const auto id = in.get<std::uint8_t>();
            const auto component = std::find_if(components_.begin(), components_.end(), [&](const Component& c) { return c.id == id; });
            require(component != components_.end(), "a scan has a component that the frame has not");
            require(quantisation_[component->quantisation & 3], "a quantisation table is missing");
            tables.push_back(in.get<std::uint8_t>());
        }
        const bool direct = !progressive_ || in.get<std::uint8_t>() == 0, alternating = !progressive_ || !direct;
        for (const std::uint8_t t : tables)
            require((!direct || huffman_[0][t >> 4 & 3]) && (!alternating || huffman_[1][t & 3]), "a Huffman table is missing");
    }

    File file_;
    bool progressive_ = false;
    std::array<std::array<bool, 4>, 2> huffman_{}; // direct, alternating: which are defined
    std::array<bool, 4> quantisation_{};
    std::vector<Component> components_;
};

} // namespace

void fenceStb(File file, std::uint64_t width, std::uint64_t height) {
    const bool png = file[0] == 0x89;
    requireHeld(file, width, height, png ? kDensestPng : kDensestJpeg);
    if (png)
        checkPngChunks(file);
    else if (JpegSegments(file).check() > kMaxJpegVisits / (width * height))
        throw Malformed{"it comes in too many scans"};
}

void fenceHdr(File file, std::uint64_t width, std::uint64_t height) { requireHeld(file, width, height, kDensestHdr); }

} // namespace cmpg
