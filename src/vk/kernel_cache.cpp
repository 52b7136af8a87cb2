// The folder of specialised kernels. The key of a file is what its code was made of: the digest of the module, the version of what specialises, the
// constants. The name of the file is a hash of it.
#include "vk/kernel_cache.h"

#include "base/byte_stream.h"
#include "base/descriptor.h"
#include "base/hash.h"
#include "vk/kernel_file.h"
#include "vk/specialize.h"
#include "vk/spirv.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace cmpg {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostFileBytes = 16 << 20, kNameDigits = 16;
constexpr std::string_view kSuffix = ".spirv", kPart = ".part"; // a file while it is written: name.spirv.partXXXXXX

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
