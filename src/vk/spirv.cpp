// The table of embedded kernels; the build generates spirv_table.inc.
#include "vk/spirv.h"

#include "spirv_table.inc"

#include <stdexcept>
#include <string>

namespace cmpg {

namespace {
std::span<const EmbeddedKernel> additional;

const EmbeddedKernel* find(std::span<const EmbeddedKernel> table, std::string_view name) {
    for (const EmbeddedKernel& kernel : table)
        if (kernel.name == name)
            return &kernel;
    return nullptr;
}
} // namespace

std::span<const EmbeddedKernel> embeddedKernels() { return kEmbeddedKernels; }

void addKernels(std::span<const EmbeddedKernel> more) { additional = more; }

const EmbeddedKernel& findKernel(std::string_view name) {
    if (const EmbeddedKernel* kernel = find(kEmbeddedKernels, name))
        return *kernel;
    if (const EmbeddedKernel* kernel = find(additional, name))
        return *kernel;
    throw std::logic_error("there is no kernel '" + std::string(name) + "'");
}

} // namespace cmpg
