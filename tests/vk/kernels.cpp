// The table of test kernels; the build generates spirv_table.inc.
#include "kernels.h"

#include "vk/spirv.h"

#include "spirv_table.inc"

namespace cmpg::test {

namespace {
[[maybe_unused]] const bool registered = (addKernels(kEmbeddedKernels), true);

Device create(bool portable) { return Device({.select = {}, .validation = false, .portable = portable}); }
} // namespace

Device& device() {
    static Device shared = create(false);
    return shared;
}

Device& portableDevice() {
    static Device shared = create(true);
    return shared;
}

} // namespace cmpg::test
