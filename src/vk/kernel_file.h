// The file of a specialised kernel.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// `key` says what the code was made of (kernelKey in kernel_cache.h).
std::vector<std::uint8_t> encodeKernel(const std::string& key, std::span<const std::uint32_t> words);
// The code in a file: nothing, unless it is whole, undamaged and of this key, and its instructions end where it does. At most 2^22 words.
std::optional<std::vector<std::uint32_t>> decodeKernel(std::span<const std::uint8_t> bytes, const std::string& key);

} // namespace cmpg
