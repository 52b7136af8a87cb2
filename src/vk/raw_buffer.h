// A buffer with memory of its own, outside all accounting.
#pragma once

#include "vk/vulkan.h"

#include <cstddef>
#include <cstdint>

namespace cmpg {

struct RawBuffer {
    vk::raii::DeviceMemory memory{nullptr};
    vk::raii::Buffer buffer{nullptr};
    std::uint64_t allocated = 0;  // bytes of memory
    std::byte* mapped = nullptr;  // null: the host cannot reach it
};

} // namespace cmpg
