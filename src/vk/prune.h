// Constants put into a kernel, and what they leave unreached taken out: in milliseconds most of what SPIRV-Tools would have to go through.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cmpg {

// The module with specialization constant i replaced by `constants[i]`, others by their defaults; without the functions that nothing calls then, and with
// nothing in blocks that control flow does not reach, and branches there that always go the same way. Blocks stay, so that control flow is structured as it was.
// What else is known of values (of floats, of memory) is left to others. Throws std::invalid_argument where the words are no SPIR-V.
std::vector<std::uint32_t> prune(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants);

} // namespace cmpg
