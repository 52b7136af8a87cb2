// Specialization by SPIRV-Tools.
#include "vk/specialize.h"

#include "vk/spirv_reflection.h"

#include <spirv-tools/optimizer.hpp>
#include <stdexcept>
#include <unordered_map>

namespace cmpg {

std::vector<std::uint32_t> specialize(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants) {
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> values;
    for (const std::uint32_t id : reflect(spirv, constants).specIds)
        if (id < constants.size())
            values[id] = {constants[id]};
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
        .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
        .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        .RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
        .RegisterPass(spvtools::CreateAggressiveDCEPass())
        .RegisterPass(spvtools::CreateBlockMergePass()) // branches that are gone leave chains of empty blocks
        .RegisterPass(spvtools::CreateEliminateDeadConstantPass());
    std::vector<std::uint32_t> result;
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);
    if (!optimizer.Run(spirv.data(), spirv.size(), &result, options))
        throw std::logic_error("a kernel cannot be specialised");
    return result;
}

std::string specializerVersion() { return std::string(spvSoftwareVersionDetailsString()) + '\n' + CMPG_SPECIALIZER; }

} // namespace cmpg
