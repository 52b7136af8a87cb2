// Sizes of a kernel before and after specialization.
#include "vk/spirv_size.h"

#include "vk/impl.h"
#include "vk/spirv.h"

namespace cmpg {

SpirvSize spirvSize(const Device& device, std::string_view name, std::span<const std::uint32_t> constants) {
    const EmbeddedKernel& kernel = findKernel(name);
    const KernelModule& module = kernel.variant(device.variant());
    return {module.words.size_bytes(), device.impl().kernelCache.specialised(module, constants).size() * sizeof(std::uint32_t)};
}

} // namespace cmpg
