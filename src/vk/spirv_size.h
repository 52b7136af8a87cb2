// How large a kernel is for a driver: its module, and what specialization leaves of it.
#pragma once

#include "vk/device.h"

namespace cmpg {

struct SpirvSize {
    std::uint64_t module = 0;      // bytes of SPIR-V, all features in it
    std::uint64_t specialised = 0; // after the constants are put in and what they leave unused is taken out, as every driver does first
};

// As Kernel's constructor; compiles nothing.
SpirvSize spirvSize(const Device& device, std::string_view name, std::span<const std::uint32_t> constants);

} // namespace cmpg
