// Specialised kernels in the user's cache folder: to make one costs a tenth of a second of processor time, to read it less than a millisecond.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

struct KernelModule;

// One file a kernel, written aside and renamed, so that any number of processes share a folder without locks. What fails, fails silently: without a
// cache the same code is made anew.
class KernelCache {
  public:
    static constexpr std::uint64_t kMostBytes = std::uint64_t(64) << 20;

    explicit KernelCache(std::filesystem::path folder = folderFromEnvironment(), std::uint64_t mostBytes = kMostBytes); // an empty path: no cache
    // CMPG_CACHE names the folder, or says 0 for none; otherwise it is cmpg-vk in the user's cache folder.
    static std::filesystem::path folderFromEnvironment();

    // As specialize() makes it.
    std::vector<std::uint32_t> specialised(const KernelModule& module, std::span<const std::uint32_t> constants) const;

    std::filesystem::path fileOf(const std::string& key) const;

  private:
    std::optional<std::vector<std::uint32_t>> read(const std::string& key) const;
    void write(const std::string& key, std::span<const std::uint32_t> words) const;
    bool makeFolder() const;
    void removeOldest() const;

    std::filesystem::path folder_;
    std::uint64_t mostBytes_;
};

// What code is known by: what it was made of.
std::string kernelKey(const KernelModule& module, std::span<const std::uint32_t> constants);

} // namespace cmpg
