// The kernels compiled into the program: SPIR-V by name, in two variants.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace cmpg {

struct EmbeddedKernel {
    std::string_view name;
    std::span<const std::uint32_t> full, portable; // see cmake/Shaders.cmake
};

// Throws std::logic_error when there is no kernel of that name.
const EmbeddedKernel& findKernel(std::string_view name);

// Every kernel of the library.
std::span<const EmbeddedKernel> embeddedKernels();

// Makes further kernels known to findKernel(); `more` must outlive its use. For kernels that only tests have.
void addKernels(std::span<const EmbeddedKernel> more);

} // namespace cmpg
