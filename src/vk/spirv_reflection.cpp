// Reads a kernel's interface from its SPIR-V.
#include "vk/spirv_reflection.h"

#include "vk/spirv_words.h"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

namespace cmpg {

using namespace spirv;

namespace {

enum ImageFormat : std::uint32_t { ImageFormatR32f = 3, ImageFormatR32ui = 33 };
enum StorageClass : std::uint32_t { ClassUniformConstant = 0, ClassUniform = 2, ClassPushConstant = 9, ClassStorageBuffer = 12 };
constexpr std::uint32_t kModeLocalSize = 17, kModeLocalSizeId = 38, kBuiltInWorkgroupSize = 25, kDimBuffer = 5;
constexpr std::uint32_t kCapabilityFloat64 = 10, kCapabilityInt64 = 11, kCapabilityInt64Atomics = 12;

// What the module says about its ids.
struct Module {
    std::map<std::uint32_t, Instruction> definitions;                               // types, constants, by result id
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> decorations;   // (id, decoration) -> operand
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> memberOffsets; // (struct, member) -> bytes
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> matrixStrides; // (struct, member) -> bytes
    std::vector<Instruction> variables;
    std::array<std::uint32_t, 3> localSize{1, 1, 1};
    std::array<std::uint32_t, 3> localSizeIds{};
    std::span<const std::uint32_t> constants;

    const Instruction& definition(std::uint32_t id) const {
        const auto found = definitions.find(id);
        if (found == definitions.end())
            fail("an id is not defined");
        return found->second;
    }

    const std::uint32_t* decoration(std::uint32_t id, Decoration which) const {
        const auto found = decorations.find({id, which});
        return found == decorations.end() ? nullptr : &found->second;
    }

    // A 32-bit scalar constant, specialized where it can be.
    std::uint32_t value(std::uint32_t id) const {
        const Instruction& constant = definition(id);
        if (constant.op != OpConstant && constant.op != OpSpecConstant)
            fail("a size is computed from constants, which is not supported");
        if (const std::uint32_t* spec = decoration(id, DecorationSpecId); spec && *spec < constants.size())
            return constants[*spec];
        return constant.at(3);
    }

    // Bytes of a type as laid out in a block; `matrixStride` is that of the member it is in.
    std::uint32_t size(std::uint32_t id, std::uint32_t matrixStride = 0, int depth = 0) const {
        if (depth > 16)
            fail("types are nested too deeply");
        const Instruction& type = definition(id);
        switch (type.op) {
        case OpTypeInt:
        case OpTypeFloat: return type.at(2) / 8;
        case OpTypeVector: return type.at(3) * size(type.at(2), 0, depth + 1);
        case OpTypeMatrix: return (type.at(3) - 1) * matrixStride + size(type.at(2), 0, depth + 1);
        case OpTypeArray: {
            const std::uint32_t* stride = decoration(id, DecorationArrayStride);
            return value(type.at(3)) * (stride ? *stride : size(type.at(2), matrixStride, depth + 1));
        }
        case OpTypeStruct: {
            std::uint32_t end = 0;
            for (std::uint32_t member = 0; member + 2 < type.words.size(); ++member) {
                const auto offset = memberOffsets.find({id, member});
                const auto stride = matrixStrides.find({id, member});
                if (offset == memberOffsets.end())
                    fail("a block member has no offset");
                end = std::max(end, offset->second + size(type.at(member + 2),
                                                          stride == matrixStrides.end() ? 0 : stride->second, depth + 1));
            }
            return end;
        }
        default: fail("a block holds an unknown type");
        }
    }
};

void readInstruction(const Instruction& i, Module& module, KernelInterface& result) {
    switch (i.op) {
    case OpCapability:
        result.float64 |= i.at(1) == kCapabilityFloat64;
        result.int64 |= i.at(1) == kCapabilityInt64;
        result.int64Atomics |= i.at(1) == kCapabilityInt64Atomics;
        break;
    case OpExecutionMode:
        if (i.at(2) == kModeLocalSize)
            module.localSize = {i.at(3), i.at(4), i.at(5)};
        break;
    case OpExecutionModeId:
        if (i.at(2) == kModeLocalSizeId)
            module.localSizeIds = {i.at(3), i.at(4), i.at(5)};
        break;
    case OpDecorate:
        module.decorations[{i.at(1), i.at(2)}] = i.words.size() > 3 ? i.at(3) : 0;
        break;
    case OpMemberDecorate:
        if (i.at(3) == DecorationOffset)
            module.memberOffsets[{i.at(1), i.at(2)}] = i.at(4);
        if (i.at(3) == DecorationMatrixStride)
            module.matrixStrides[{i.at(1), i.at(2)}] = i.at(4);
        break;
    case OpTypeInt:
    case OpTypeFloat:
    case OpTypeVector:
    case OpTypeMatrix:
    case OpTypeImage:
    case OpTypeSampledImage:
    case OpTypeArray:
    case OpTypeStruct:
    case OpTypePointer: module.definitions[i.at(1)] = i; break;
    case OpConstant:
    case OpConstantComposite:
    case OpSpecConstantTrue:
    case OpSpecConstantFalse:
    case OpSpecConstant:
    case OpSpecConstantComposite: module.definitions[i.at(2)] = i; break;
    case OpVariable: module.variables.push_back(i); break;
    default: break;
    }
}

void readVariable(const Instruction& variable, const Module& module, KernelInterface& result) {
    const std::uint32_t storageClass = variable.at(3);
    if (storageClass != ClassUniformConstant && storageClass != ClassUniform && storageClass != ClassPushConstant &&
        storageClass != ClassStorageBuffer)
        return;
    std::uint32_t typeId = module.definition(variable.at(1)).at(3); // what the pointer points to
    if (storageClass == ClassPushConstant) {
        result.pushBytes = module.size(typeId);
        return;
    }
    const std::uint32_t* binding = module.decoration(variable.at(2), DecorationBinding);
    const std::uint32_t* set = module.decoration(variable.at(2), DecorationDescriptorSet);
    if (!binding || (set && *set != 0))
        fail("a resource has no binding number or is not in set 0");
    if (storageClass == ClassStorageBuffer) {
        result.bindings.push_back({*binding, KernelInterface::Resource::Storage});
        return;
    }
    if (storageClass == ClassUniform) {
        result.bindings.push_back({*binding, KernelInterface::Resource::Uniform});
        return;
    }
    if (module.definition(typeId).op == OpTypeSampledImage)
        typeId = module.definition(typeId).at(2);
    const Instruction& image = module.definition(typeId);
    // The seventh operand: 1, read through a sampler; 2, a storage image, whose variable must say that nothing is written.
    const std::uint32_t sampled = image.op == OpTypeImage && image.at(3) == kDimBuffer ? image.at(7) : 0;
    if (sampled != 1 && !(sampled == 2 && module.decoration(variable.at(2), DecorationNonWritable)))
        fail("binding " + std::to_string(*binding) + " is neither a storage buffer nor a read-only texel buffer");
    using Resource = KernelInterface::Resource;
    const bool isFloat = module.definition(image.at(2)).op == OpTypeFloat;
    const bool oneNumber = image.at(8) == ImageFormatR32f || image.at(8) == ImageFormatR32ui;
    result.bindings.push_back({*binding,
                               sampled == 1 ? (isFloat ? Resource::TexelFloat : Resource::TexelUint)
                                            : (isFloat ? Resource::StorageTexelFloat : Resource::StorageTexelUint),
                               oneNumber});
}

std::array<std::uint32_t, 3> readLocalSize(const Module& module) {
    // A constant decorated WorkgroupSize outranks the execution mode.
    for (const auto& [key, builtIn] : module.decorations)
        if (key.second == DecorationBuiltIn && builtIn == kBuiltInWorkgroupSize) {
            const Instruction& size = module.definition(key.first);
            return {module.value(size.at(3)), module.value(size.at(4)), module.value(size.at(5))};
        }
    if (module.localSizeIds[0])
        return {module.value(module.localSizeIds[0]), module.value(module.localSizeIds[1]), module.value(module.localSizeIds[2])};
    return module.localSize;
}

} // namespace

bool isWhole(std::span<const std::uint32_t> words) {
    try {
        forEachInstruction(words, [](const Instruction&) {});
        return true;
    } catch (const std::invalid_argument&) {
        return false;
    }
}

KernelInterface reflect(std::span<const std::uint32_t> words, std::span<const std::uint32_t> constants) {
    KernelInterface result;
    Module module;
    module.constants = constants;
    forEachInstruction(words, [&](const Instruction& instruction) { readInstruction(instruction, module, result); });
    for (const Instruction& variable : module.variables)
        readVariable(variable, module, result);
    // Several declarations may stand for one binding, but not of different kinds.
    std::sort(result.bindings.begin(), result.bindings.end());
    result.bindings.erase(std::unique(result.bindings.begin(), result.bindings.end()), result.bindings.end());
    for (std::size_t i = 1; i < result.bindings.size(); ++i)
        if (result.bindings[i].number == result.bindings[i - 1].number)
            fail("binding " + std::to_string(result.bindings[i].number) + " is declared as two kinds of resource");
    for (const auto& [key, operand] : module.decorations)
        if (key.second == DecorationSpecId)
            result.specIds.push_back(operand);
    // The compiler writes two constants of one id where a workgroup size is specialized and also read.
    std::sort(result.specIds.begin(), result.specIds.end());
    result.specIds.erase(std::unique(result.specIds.begin(), result.specIds.end()), result.specIds.end());
    result.localSize = readLocalSize(module);
    return result;
}

} // namespace cmpg
