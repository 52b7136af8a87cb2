// Whole files in and out: bounded reads, and writes that never leave half a file behind.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace cmpg {

using Bytes = std::vector<std::uint8_t>;

// 4 GiB: the most a .glb can say of itself (its length field has 32 bits); larger files are not what we expect.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t(1) << 32;

// Whether something has this name; false, too, where that cannot be told, as of a name too long.
bool fileExists(const std::filesystem::path& file);

// Throws Error(Input) for a file that is missing, unreadable, not a regular file, or larger than `maxBytes`.
Bytes readFile(const std::filesystem::path& file, std::uintmax_t maxBytes = kMaxFileBytes);

// Writes beside the target and renames, creating the folder if need be. Throws Error(Output).
void writeFile(const std::filesystem::path& file, std::span<const std::uint8_t> bytes);

} // namespace cmpg
