// Files of specialised kernels. Little endian: magic, key, number of words, the words by zlib, CRC-32 of all before. The key is what the code was made
// of: the digest of the module, the version of what specialises, the constants. It is compared whole; the name of the file is a hash of it.
#include "vk/kernel_cache.h"

#include "base/byte_stream.h"
#include "base/descriptor.h"
#include "base/hash.h"
#include "vk/specialize.h"
#include "vk/spirv.h"
#include "vk/spirv_reflection.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

namespace cmpg {
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kMagic = 0x0a434b4347504d43; // "CMPGCKC\n"
constexpr std::size_t kMostFileBytes = 16 << 20, kMostWords = 4 << 20, kNameDigits = 16;
constexpr int kLevel = 1; // of compression: a third is left, as of higher ones that take longer
constexpr std::string_view kSuffix = ".spirv", kPart = ".part"; // a file while it is written: name.spirv.partXXXXXX

std::uint32_t checksum(std::span<const std::uint8_t> bytes) { return std::uint32_t(crc32_z(0, bytes.data(), bytes.size())); }

// A folder may hold other things: they are neither counted nor removed.
bool isOurs(const std::string& name) {
    return name.size() >= kNameDigits + kSuffix.size() && name.find_first_not_of("0123456789abcdef") == kNameDigits &&
           name.compare(kNameDigits, kSuffix.size(), kSuffix) == 0 &&
           (name.size() == kNameDigits + kSuffix.size() || name.compare(kNameDigits + kSuffix.size(), kPart.size(), kPart) == 0);
}

// Nothing unless it is a file of this user's: others must not have a driver compile what they like.
std::optional<std::vector<std::uint8_t>> readOwn(const Descriptor& file) {
    struct stat status {};
    if (file.get() < 0 || ::fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::geteuid() || status.st_size < 0 ||
        std::uint64_t(status.st_size) > kMostFileBytes)
        return {};
    std::vector<std::uint8_t> bytes(std::size_t(status.st_size));
    if (!readAll(file.get(), bytes))
        return {};
    ::futimens(file.get(), nullptr); // the oldest to go is the one used longest ago
    return bytes;
}

} // namespace

std::string kernelKey(const KernelModule& module, std::span<const std::uint32_t> constants) {
    ByteWriter key;
    key.put(std::string(module.digest));
    key.put(specializerVersion());
    key.count(constants.size());
    for (const std::uint32_t constant : constants)
        key.put(constant);
    return {key.bytes.begin(), key.bytes.end()};
}

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

KernelCache::KernelCache(fs::path folder, std::uint64_t mostBytes) : folder_(std::move(folder)), mostBytes_(mostBytes) {}

fs::path KernelCache::folderFromEnvironment() {
    const auto value = [](const char* name) {
        const char* text = std::getenv(name);
        return std::string(text ? text : "");
    };
    if (const std::string chosen = value("CMPG_CACHE"); !chosen.empty())
        return chosen == "0" ? fs::path() : fs::path(chosen);
    // As the XDG Base Directory Specification has it: what is not absolute counts for nothing.
    if (const fs::path caches = value("XDG_CACHE_HOME"); caches.is_absolute())
        return caches / "cmpg-vk";
    if (const fs::path home = value("HOME"); home.is_absolute())
        return home / ".cache/cmpg-vk";
    return {};
}

std::vector<std::uint32_t> KernelCache::specialised(const KernelModule& module, std::span<const std::uint32_t> constants) const {
    if (folder_.empty())
        return specialize(module.words, constants);
    const std::string key = kernelKey(module, constants);
    if (auto known = read(key))
        return std::move(*known);
    std::vector<std::uint32_t> made = specialize(module.words, constants);
    write(key, made);
    return made;
}

fs::path KernelCache::fileOf(const std::string& key) const {
    char name[kNameDigits + 1];
    std::snprintf(name, sizeof name, "%016llx", static_cast<unsigned long long>(hashOf(std::as_bytes(std::span(key)))));
    return folder_ / (std::string(name) + std::string(kSuffix));
}

std::optional<std::vector<std::uint32_t>> KernelCache::read(const std::string& key) const {
    const auto bytes = readOwn(Descriptor(fileOf(key), O_RDONLY | O_NONBLOCK)); // a pipe would have it wait
    return bytes ? decodeKernel(*bytes, key) : std::nullopt;
}

bool KernelCache::makeFolder() const {
    std::error_code error;
    if (fs::exists(folder_, error))
        return true;
    fs::create_directories(folder_.parent_path(), error);
    return ::mkdir(folder_.c_str(), 0700) == 0 || errno == EEXIST;
}

void KernelCache::write(const std::string& key, std::span<const std::uint32_t> words) const {
    const std::vector<std::uint8_t> bytes = encodeKernel(key, words);
    if (bytes.size() > std::min<std::uint64_t>(kMostFileBytes, mostBytes_) || !makeFolder())
        return;
    const fs::path file = fileOf(key);
    std::string aside = file.string() + std::string(kPart) + "XXXXXX";
    Descriptor out(::mkostemp(aside.data(), O_CLOEXEC)); // machines that share a folder have processes of one number
    if (out.get() < 0)
        return;
    // Nothing is synced: what a loss of power leaves, the checksum finds.
    if (!writeAll(out.get(), bytes) || !out.close() || ::rename(aside.c_str(), file.c_str()) != 0) {
        ::unlink(aside.c_str());
        return;
    }
    removeOldest();
}

void KernelCache::removeOldest() const {
    struct Entry {
        fs::file_time_type used;
        std::uint64_t bytes;
        fs::path path;
    };
    std::vector<Entry> entries;
    std::uint64_t sum = 0;
    std::error_code error;
    for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
        if (!isOurs(it->path().filename().string()))
            continue;
        std::error_code gone; // another process may remove it meanwhile
        const std::uint64_t bytes = it->file_size(gone);
        const fs::file_time_type used = gone ? fs::file_time_type() : it->last_write_time(gone);
        if (gone)
            continue;
        sum += bytes;
        entries.push_back({used, bytes, it->path()});
    }
    if (sum <= mostBytes_)
        return;
    std::ranges::sort(entries, {}, &Entry::used);
    for (const Entry& entry : entries) {
        if (sum <= mostBytes_)
            break;
        fs::remove(entry.path, error);
        sum -= entry.bytes;
    }
}

} // namespace cmpg
