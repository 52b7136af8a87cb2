// Sizes of a kernel before and after specialization.
#include "vk/spirv_size.h"

#include "vk/specialize.h"
#include "vk/spirv.h"

namespace cmpg {

SpirvSize spirvSize(const Device& device, std::string_view name, std::span<const std::uint32_t> constants) {
    const EmbeddedKernel& kernel = findKernel(name);
    const std::span<const std::uint32_t> spirv = kernel.variant(device.variant());
    return {spirv.size_bytes(), specialize(spirv, constants).size() * sizeof(std::uint32_t)};
}

} // namespace cmpg
