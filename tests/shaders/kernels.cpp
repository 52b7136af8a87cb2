// Makes the kernels of this folder known; the build generates spirv_table.inc.
#include "vk/spirv.h"

#include "spirv_table.inc"

namespace cmpg::test {
namespace {

[[maybe_unused]] const bool registered = (addKernels(kEmbeddedKernels), true);

} // namespace
} // namespace cmpg::test
