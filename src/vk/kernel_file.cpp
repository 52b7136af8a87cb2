// Little endian: magic, key, number of words, the words by zlib, CRC-32 of all before. The key is compared whole.
#include "vk/kernel_file.h"

#include "base/byte_stream.h"
#include "vk/spirv_reflection.h"

#include <bit>
#include <zlib.h>

namespace cmpg {

namespace {

constexpr std::uint64_t kMagic = 0x0a434b4347504d43; // "CMPGCKC\n"
constexpr std::size_t kMostWords = 4 << 20;
constexpr int kLevel = 1; // of compression: a third is left, as of higher ones that take longer

std::uint32_t checksum(std::span<const std::uint8_t> bytes) { return std::uint32_t(crc32_z(0, bytes.data(), bytes.size())); }

} // namespace

std::vector<std::uint8_t> encodeKernel(const std::string& key, std::span<const std::uint32_t> words) {
    ByteWriter out;
    out.put(kMagic);
    out.put(key);
    out.count(words.size());
    std::vector<std::uint8_t> packed(::compressBound(uLong(words.size_bytes())));
    uLongf length = uLongf(packed.size());
    ::compress2(packed.data(), &length, reinterpret_cast<const Bytef*>(words.data()), uLong(words.size_bytes()), kLevel); // there is room
    out.count(length);
    out.bytes.insert(out.bytes.end(), packed.begin(), packed.begin() + std::ptrdiff_t(length));
    out.put(checksum(out.bytes));
    return std::move(out.bytes);
}

std::optional<std::vector<std::uint32_t>> decodeKernel(std::span<const std::uint8_t> bytes, const std::string& key) {
    try {
        ByteReader in(bytes);
        if (in.get<std::uint64_t>() != kMagic || in.text() != key)
            return {};
        const auto count = in.get<std::uint64_t>();
        const std::span<const std::uint8_t> packed = in.take(in.count(1));
        const std::size_t end = bytes.size() - sizeof(std::uint32_t);
        if (in.get<std::uint32_t>() != checksum(bytes.first(end)) || !in.atEnd() || count > kMostWords)
            return {};
        static_assert(std::endian::native == std::endian::little); // else the words would have to be turned
        std::vector<std::uint32_t> words(count);
        uLongf length = uLongf(count * sizeof(std::uint32_t));
        if (::uncompress(reinterpret_cast<Bytef*>(words.data()), &length, packed.data(), uLong(packed.size())) != Z_OK ||
            length != count * sizeof(std::uint32_t) || !isWhole(words))
            return {};
        return words;
    } catch (const Malformed&) {
        return {};
    }
}

} // namespace cmpg
