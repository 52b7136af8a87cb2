// Specialization: what follows from the constants alone by our own hand, the rest by SPIRV-Tools.
#include "vk/specialize.h"

#include "vk/prune.h"

#include <spirv-tools/optimizer.hpp>
#include <stdexcept>

namespace cmpg {

std::vector<std::uint32_t> specialize(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants) {
    const std::vector<std::uint32_t> pruned = prune(spirv, constants);
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    optimizer.RegisterPass(spvtools::CreateCCPPass())
        .RegisterPass(spvtools::CreateDeadBranchElimPass())
        .RegisterPass(spvtools::CreateAggressiveDCEPass())
        .RegisterPass(spvtools::CreateBlockMergePass()) // branches that are gone leave chains of empty blocks
        .RegisterPass(spvtools::CreateEliminateDeadConstantPass());
    std::vector<std::uint32_t> result;
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);
    if (!optimizer.Run(pruned.data(), pruned.size(), &result, options))
        throw std::logic_error("a kernel cannot be specialised");
    return result;
}

std::string specializerVersion() { return std::string(spvSoftwareVersionDetailsString()) + '\n' + CMPG_SPECIALIZER; }

} // namespace cmpg
