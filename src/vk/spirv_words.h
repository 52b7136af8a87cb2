// SPIR-V as words: instructions, and the numbers of those that src/vk looks at (Khronos SPIR-V specification 1.6, section 3).
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace cmpg::spirv {

enum Op : std::uint32_t {
    OpUndef = 1,
    OpEntryPoint = 15,
    OpExecutionMode = 16,
    OpCapability = 17,
    OpTypeVoid = 19, // the first type
    OpTypeBool = 20,
    OpTypeInt = 21,
    OpTypeFloat = 22,
    OpTypeVector = 23,
    OpTypeMatrix = 24,
    OpTypeImage = 25,
    OpTypeSampledImage = 27,
    OpTypeArray = 28,
    OpTypeStruct = 30,
    OpTypePointer = 32,
    OpTypePipe = 38, // the last type
    OpConstantTrue = 41,
    OpConstantFalse = 42,
    OpConstant = 43,
    OpConstantComposite = 44,
    OpSpecConstantTrue = 48,
    OpSpecConstantFalse = 49,
    OpSpecConstant = 50,
    OpSpecConstantComposite = 51,
    OpSpecConstantOp = 52,
    OpFunction = 54,
    OpFunctionParameter = 55,
    OpFunctionEnd = 56,
    OpFunctionCall = 57,
    OpVariable = 59,
    OpDecorate = 71,
    OpMemberDecorate = 72,
    OpIAdd = 128,
    OpISub = 130,
    OpIMul = 132,
    OpLogicalEqual = 164,
    OpLogicalNotEqual = 165,
    OpLogicalOr = 166,
    OpLogicalAnd = 167,
    OpLogicalNot = 168,
    OpSelect = 169,
    OpIEqual = 170,
    OpINotEqual = 171,
    OpUGreaterThan = 172,
    OpUGreaterThanEqual = 174,
    OpULessThan = 176,
    OpULessThanEqual = 178,
    OpShiftRightLogical = 194,
    OpShiftLeftLogical = 196,
    OpBitwiseOr = 197,
    OpBitwiseXor = 198,
    OpBitwiseAnd = 199,
    OpNot = 200,
    OpPhi = 245,
    OpLoopMerge = 246,
    OpSelectionMerge = 247,
    OpLabel = 248,
    OpBranch = 249,
    OpBranchConditional = 250,
    OpReturn = 253,
    OpReturnValue = 254,
    OpUnreachable = 255,
    OpExecutionModeId = 331,
};
enum Decoration : std::uint32_t {
    DecorationSpecId = 1,
    DecorationArrayStride = 6,
    DecorationMatrixStride = 7,
    DecorationBuiltIn = 11,
    DecorationNonWritable = 24,
    DecorationBinding = 33,
    DecorationDescriptorSet = 34,
    DecorationOffset = 35,
    DecorationNoContraction = 42,
};
constexpr std::uint32_t kMagic = 0x07230203, kHeaderWords = 5, kBoundWord = 3; // ids are below the bound

[[noreturn]] inline void fail(const std::string& reason) { throw std::invalid_argument("cannot read SPIR-V: " + reason); }

struct Instruction {
    std::uint32_t op = 0;
    std::span<const std::uint32_t> words; // all of it, so that words[1] is the first operand

    std::uint32_t at(std::size_t i) const {
        if (i >= words.size())
            fail("an instruction is too short");
        return words[i];
    }
};

// Calls use(instruction) for each.
template <class Use> void forEachInstruction(std::span<const std::uint32_t> words, Use use) {
    if (words.size() < kHeaderWords || words[0] != kMagic)
        fail("no SPIR-V header");
    for (std::size_t at = kHeaderWords; at < words.size();) {
        const std::uint32_t length = words[at] >> 16; // words, the first included
        if (length == 0 || length > words.size() - at)
            fail("an instruction reaches over the end");
        use(Instruction{words[at] & 0xffffu, words.subspan(at, length)});
        at += length;
    }
}

} // namespace cmpg::spirv
