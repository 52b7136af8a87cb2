// The kernels compiled into the program: SPIR-V by name, in three variants.
#pragma once

#include "vk/device.h"

#include <cstdint>
#include <span>
#include <string_view>

namespace cmpg {

struct KernelModule {
    std::span<const std::uint32_t> words;
    std::string_view digest; // SHA-256, of variant and words
};

struct EmbeddedKernel {
    std::string_view name;
    KernelModule full, cpu, portable; // see cmake/Shaders.cmake

    const KernelModule& variant(KernelVariant v) const { return v == KernelVariant::Full ? full : v == KernelVariant::Cpu ? cpu : portable; }
};

// Throws std::logic_error when there is no kernel of that name.
const EmbeddedKernel& findKernel(std::string_view name);

// Every kernel of the library.
std::span<const EmbeddedKernel> embeddedKernels();

// Makes further kernels known to findKernel(); `more` must outlive its use. For kernels that only tests have.
void addKernels(std::span<const EmbeddedKernel> more);

} // namespace cmpg
