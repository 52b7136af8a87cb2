// Guide files: as they are, and with their size and checksum made right, so that what stands behind these is reached.
#include "base/byte_stream.h"
#include "fuzz.h"
#include "guiding/guide_file.h"

#include <limits>

using namespace cmpg;

namespace {

constexpr std::size_t kHeaderBytes = 8 + 4 + 8, kChecksumBytes = 8; // magic, version, size of what follows

void overwrite(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint64_t value) {
    for (std::size_t i = 0; i < 8; ++i)
        bytes[at + i] = std::uint8_t(value >> (8 * i));
}

std::vector<std::uint8_t> repaired(fuzz::Input input) {
    std::vector<std::uint8_t> bytes(input.begin(), input.end());
    if (bytes.size() < kHeaderBytes + kChecksumBytes)
        return bytes;
    const std::size_t end = bytes.size() - kChecksumBytes;
    overwrite(bytes, kHeaderBytes - 8, end - kHeaderBytes);
    std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a
    for (std::size_t i = 0; i < end; ++i)
        hash = (hash ^ bytes[i]) * 0x100000001b3;
    overwrite(bytes, end, hash);
    return bytes;
}

std::vector<std::uint8_t> bytesOf(const SdTree& tree) {
    ByteWriter out;
    putTree(out, tree);
    return out.bytes;
}

// What a renderer does with a guide, but for the device.
void use(SdTree tree) {
    const std::vector<std::uint8_t> written = bytesOf(tree);
    ByteReader in(written);
    fuzz::require(bytesOf(getTree(in)) == written, "a tree that was read is written and read again as it was");
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kMost = std::numeric_limits<float>::max();
    for (const glm::vec3 p : {glm::vec3(0), glm::vec3(kNan), glm::vec3(kMost, -kMost, 1), tree.lower(), tree.upper()})
        fuzz::require(tree.cellAt(p) < tree.cells().size(), "every point has a cell");
    tree.limitNodes(1 << 14); // as --guide-memory does
    std::vector<CellRecords> records;
    for (std::uint32_t cell = 0; cell < std::min<std::size_t>(tree.cells().size(), 4); ++cell) {
        const std::array<GuideMass, 4> leaf = {{{1, 0, 0}, {0, 2, 1}, {1e20, 1, 0}, {0, 0, 0}}};
        records.push_back({cell, 10'000, 3, 1, std::vector(tree.cells()[cell].nodes.size(), leaf)});
    }
    tree.update(records);
    fuzz::require(tree.validate().empty(), "a tree that learns stays valid");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::MemoryFile file;
    const fuzz::Input input(data, size);
    fuzz::accepts({ErrorKind::Input}, [&] { loadGuide(file.holding(input)); });
    fuzz::accepts({ErrorKind::Input}, [&] { use(loadGuide(file.holding(repaired(input))).tree); });
    return 0;
}
