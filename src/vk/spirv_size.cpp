// Specialization by SPIRV-Tools, for sizes alone: the device gets the module and its constants.
#include "vk/spirv_size.h"

#include "vk/spirv.h"
#include "vk/spirv_reflection.h"

#include <spirv-tools/optimizer.hpp>
#include <stdexcept>
#include <unordered_map>

namespace cmpg {

SpirvSize spirvSize(const Device& device, std::string_view name, std::span<const std::uint32_t> constants) {
    const EmbeddedKernel& kernel = findKernel(name);
    const std::span<const std::uint32_t> spirv = kernel.variant(device.variant());
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> values;
    for (const std::uint32_t id : reflect(spirv, constants).specIds)
        if (id < constants.size())
            values[id] = {constants[id]};
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
        .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
        .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
        .RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        .RegisterPass(spvtools::CreateAggressiveDCEPass())
        .RegisterPass(spvtools::CreateEliminateDeadConstantPass());
    std::vector<std::uint32_t> result;
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);
    if (!optimizer.Run(spirv.data(), spirv.size(), &result, options))
        throw std::logic_error("kernel '" + std::string(name) + "' cannot be specialised");
    return {spirv.size_bytes(), result.size() * sizeof(std::uint32_t)};
}

} // namespace cmpg
