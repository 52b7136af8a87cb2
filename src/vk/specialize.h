// Kernels with their specialization constants replaced by values, so that drivers are given only what is left.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// The module with constant i replaced by `constants[i]`, without the branches, functions and variables that this switches off.
// Drivers could do the same, and lavapipe takes three times as long for the whole: it inlines all functions before it looks at a branch.
std::vector<std::uint32_t> specialize(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants);

// Of SPIRV-Tools and of what is asked of it: the same version makes the same code.
std::string specializerVersion();

} // namespace cmpg
