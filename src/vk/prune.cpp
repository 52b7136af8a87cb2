// Knows a value where it follows from constants alone, and a block as unreached where all branches to it are known to go elsewhere. Begins by taking all blocks
// for reached; what follows from that stays true when there are fewer, so that it can be repeated until nothing changes.
#include "vk/prune.h"

#include "vk/spirv_words.h"

#include <algorithm>
#include <array>
#include <optional>
#include <unordered_map>
#include <utility>

namespace cmpg {

using namespace spirv;

namespace {

using Words = std::span<const std::uint32_t>;
using Value = std::optional<std::uint32_t>; // of a bool or a number of 32 bits, where it is known

struct Block {
    std::uint32_t label = 0;
    std::vector<Instruction> body;
    std::vector<std::size_t> next; // blocks that control flow may go to from here
    bool reached = true;
};

struct Function {
    Instruction head;
    std::vector<Instruction> parameters;
    std::vector<Block> blocks;
    std::unordered_map<std::uint32_t, std::size_t> places; // of blocks, by label
    bool called = true;
    Value result; // of every call

    std::size_t placeOf(std::uint32_t label) const {
        const auto found = places.find(label);
        if (found == places.end())
            fail("a branch goes to no block");
        return found->second;
    }
};

Value ofTwo(std::uint32_t op, Value x, Value y) {
    // One may be enough.
    if (op == OpLogicalAnd || op == OpBitwiseAnd || op == OpIMul)
        if (x == 0u || y == 0u)
            return 0;
    if (op == OpLogicalOr && (x == 1u || y == 1u))
        return 1;
    if (!x || !y)
        return {};
    const std::uint32_t a = *x, b = *y;
    switch (op) {
    case OpIAdd: return a + b;
    case OpISub: return a - b;
    case OpIMul: return a * b;
    case OpLogicalEqual:
    case OpIEqual: return a == b;
    case OpLogicalNotEqual:
    case OpINotEqual: return a != b;
    case OpLogicalOr:
    case OpBitwiseOr: return a | b;
    case OpLogicalAnd:
    case OpBitwiseAnd: return a & b;
    case OpBitwiseXor: return a ^ b;
    case OpUGreaterThan: return a > b;
    case OpUGreaterThanEqual: return a >= b;
    case OpULessThan: return a < b;
    case OpULessThanEqual: return a <= b;
    case OpShiftRightLogical: return b < 32 ? Value(a >> b) : Value();
    case OpShiftLeftLogical: return b < 32 ? Value(a << b) : Value();
    default: return {};
    }
}

class Pruning {
  public:
    Pruning(Words words, Words constants) : words_(words), constants_(constants) {
        if (words.size() < kHeaderWords)
            fail("no SPIR-V header");
        const std::uint32_t bound = words[kBoundWord];
        if (bound > words.size()) // every id takes a word at least where it is defined
            fail("ids are out of range");
        values_.resize(bound);
        kinds_.resize(bound, Kind::NoType);
        specIds_.resize(bound);
        functionOf_.resize(bound, kNone);
        forEachInstruction(words, [&](const Instruction& i) { read(i); });
        if (entry_ == 0 || functionOf_.at(entry_) == kNone)
            fail("no entry point");
        for (Function& f : functions_)
            for (const Block& b : f.blocks)
                if (b.body.empty())
                    fail("a block is empty");
    }

    void follow() {
        for (bool more = true; more;) {
            changed_ = false;
            for (Function& f : functions_)
                f.called = false;
            std::vector<std::size_t> left{functionOf_[entry_]};
            functions_[left[0]].called = true;
            while (!left.empty()) {
                const std::size_t f = left.back();
                left.pop_back();
                findReached(functions_[f]);
                evaluate(functions_[f], left);
            }
            more = changed_;
        }
    }

    std::vector<std::uint32_t> result() const {
        std::vector<std::uint32_t> out(words_.begin(), words_.begin() + kHeaderWords);
        out.reserve(words_.size());
        const std::array<std::uint32_t, 2> bools{out[kBoundWord], out[kBoundWord] + 1}; // false and true, for the branches that are known
        const std::vector<bool> gone = inUnreached();
        for (const Instruction& i : globals_)
            writeGlobal(i, gone, out);
        if (boolType_ != 0) {
            out[kBoundWord] += 2;
            out.insert(out.end(), {3u << 16 | OpConstantFalse, boolType_, bools[0], 3u << 16 | OpConstantTrue, boolType_, bools[1]});
        }
        for (const Function& f : functions_)
            if (f.called)
                write(f, bools, out);
        return out;
    }

  private:
    enum class Kind : std::uint8_t { NoType, OtherType, Bool, Int32 }; // of what an id stands for
    static constexpr std::size_t kNone = ~std::size_t(0);

    std::size_t id(std::uint32_t i) const {
        if (i >= values_.size())
            fail("an id is out of range");
        return i;
    }
    Value value(std::uint32_t i) const { return values_[id(i)]; }
    bool isNumber(std::uint32_t i) const { return kinds_[id(i)] >= Kind::Bool; }
    static bool isType(std::uint32_t op) { return op >= OpTypeVoid && op <= OpTypePipe; }
    // Instructions of functions name the type of their result, and then its id; those without a result begin with other ids.
    bool hasResult(const Instruction& i) const { return i.words.size() > 2 && i.words[1] < kinds_.size() && kinds_[i.words[1]] != Kind::NoType; }

    void read(const Instruction& i) {
        if (i.op == OpFunction) {
            functionOf_[id(i.at(2))] = functions_.size();
            functions_.emplace_back().head = i;
        } else if (functions_.empty()) {
            readGlobal(i);
        } else if (i.op == OpFunctionParameter) {
            functions_.back().parameters.push_back(i);
        } else if (Function& f = functions_.back(); i.op == OpLabel) {
            f.places.emplace(i.at(1), f.blocks.size());
            f.blocks.emplace_back().label = i.at(1);
        } else if (i.op != OpFunctionEnd) {
            if (f.blocks.empty())
                fail("an instruction is in no block");
            f.blocks.back().body.push_back(i);
        }
    }

    void readGlobal(const Instruction& i) {
        globals_.push_back(i);
        if (isType(i.op))
            kinds_[id(i.at(1))] = i.op == OpTypeBool ? Kind::Bool : i.op == OpTypeInt && i.at(2) == 32 ? Kind::Int32 : Kind::OtherType;
        switch (i.op) {
        case OpEntryPoint: entry_ = std::uint32_t(id(i.at(2))); break;
        case OpDecorate:
            if (i.at(2) == DecorationSpecId)
                specIds_[id(i.at(1))] = i.at(3);
            break;
        case OpTypeBool: boolType_ = i.at(1); break;
        case OpConstantTrue:
        case OpConstantFalse: values_[id(i.at(2))] = i.op == OpConstantTrue; break;
        case OpSpecConstantTrue:
        case OpSpecConstantFalse: values_[id(i.at(2))] = specialised(i.at(2), i.op == OpSpecConstantTrue) != 0; break;
        case OpConstant:
        case OpSpecConstant:
            if (isNumber(i.at(1)))
                values_[id(i.at(2))] = specialised(i.at(2), i.at(3));
            break;
        case OpSpecConstantOp:
            if (isNumber(i.at(1)))
                values_[id(i.at(2))] = computed(i.at(3), i.words.subspan(4));
            break;
        default: break;
        }
    }

    std::uint32_t specialised(std::uint32_t of, std::uint32_t otherwise) const {
        const Value& number = specIds_[id(of)];
        return number && *number < constants_.size() ? constants_[*number] : otherwise;
    }

    // Of an operation on ids that has a bool or a number of 32 bits as its result.
    Value computed(std::uint32_t op, Words operands) const {
        if (operands.size() == 3 && op == OpSelect) {
            const Value condition = value(operands[0]);
            return condition ? value(operands[*condition ? 1 : 2]) : Value();
        }
        if (operands.size() == 2 && op >= OpIAdd && op <= OpBitwiseAnd)
            return ofTwo(op, value(operands[0]), value(operands[1]));
        if (operands.size() == 1 && (op == OpLogicalNot || op == OpNot))
            if (const Value v = value(operands[0]))
                return op == OpNot ? ~*v : !*v;
        return {};
    }

    std::vector<std::size_t> nextOf(const Function& f, const Block& b) const {
        const Instruction& last = b.body.back();
        switch (last.op) {
        case OpBranch: return {f.placeOf(last.at(1))};
        case OpBranchConditional: {
            const Value condition = value(last.at(1));
            if (condition)
                return {f.placeOf(last.at(*condition ? 2 : 3))};
            return {f.placeOf(last.at(2)), f.placeOf(last.at(3))};
        }
        case OpReturn:
        case OpReturnValue:
        case OpUnreachable: return {};
        default: fail("a block ends in an instruction that is not expected"); // the compiler makes no switches for our kernels
        }
    }

    void findReached(Function& f) const {
        for (Block& b : f.blocks) {
            b.reached = false;
            b.next = nextOf(f, b);
        }
        if (f.blocks.empty())
            return;
        std::vector<std::size_t> left{0};
        f.blocks[0].reached = true;
        while (!left.empty()) {
            const Block& b = f.blocks[left.back()];
            left.pop_back();
            for (const std::size_t n : b.next)
                if (!std::exchange(f.blocks[n].reached, true))
                    left.push_back(n);
        }
    }

    // Values in the blocks that are reached. Functions that are first called here are left to follow.
    void evaluate(Function& f, std::vector<std::size_t>& left) {
        std::vector<Value> results;
        for (std::size_t place = 0; place < f.blocks.size(); ++place) {
            if (!f.blocks[place].reached)
                continue;
            for (const Instruction& i : f.blocks[place].body) {
                Value now;
                if (i.op == OpReturnValue)
                    results.push_back(value(i.at(1)));
                else if (i.op == OpFunctionCall)
                    now = call(i, left);
                else if (hasResult(i) && isNumber(i.words[1]))
                    now = i.op == OpPhi ? phi(f, place, i) : computed(i.op, i.words.subspan(3));
                if (now && !values_[id(i.at(2))]) {
                    values_[i.at(2)] = now;
                    changed_ = true;
                }
            }
        }
        if (!f.result && !results.empty() && std::all_of(results.begin(), results.end(), [&](Value v) { return v && v == results[0]; })) {
            f.result = results[0];
            changed_ = true;
        }
    }

    Value call(const Instruction& i, std::vector<std::size_t>& left) {
        const std::size_t callee = functionOf_[id(i.at(3))];
        if (callee == kNone)
            fail("a call of no function");
        if (!std::exchange(functions_[callee].called, true))
            left.push_back(callee);
        return functions_[callee].result;
    }

    // What all edges that are taken bring.
    Value phi(const Function& f, std::size_t place, const Instruction& i) const {
        Value result;
        for (std::size_t k = 3; k + 1 < i.words.size(); k += 2) {
            const Block& from = f.blocks[f.placeOf(i.words[k + 1])];
            if (!from.reached || std::find(from.next.begin(), from.next.end(), place) == from.next.end())
                continue;
            const Value v = value(i.words[k]);
            if (!v || (result && result != v))
                return {};
            result = v;
        }
        return result;
    }

    // By id, what is defined where nothing is kept.
    std::vector<bool> inUnreached() const {
        std::vector<bool> gone(values_.size());
        for (const Function& f : functions_)
            for (const Block& b : f.blocks)
                if (!f.called || !b.reached)
                    for (const Instruction& i : b.body)
                        if (hasResult(i))
                            gone[id(i.words[2])] = true;
        return gone;
    }

    void writeGlobal(const Instruction& i, const std::vector<bool>& gone, std::vector<std::uint32_t>& out) const {
        const auto as = [&](std::uint32_t op) {
            const std::size_t begin = out.size();
            out.insert(out.end(), i.words.begin(), i.words.end());
            out[begin] = (i.words[0] & 0xffff0000u) | op;
            return begin;
        };
        const auto known = [&](std::uint32_t v) {
            if (kinds_[i.at(1)] == Kind::Bool)
                out.insert(out.end(), {3u << 16 | (v ? OpConstantTrue : OpConstantFalse), i.at(1), i.at(2)});
            else
                out.insert(out.end(), {4u << 16 | OpConstant, i.at(1), i.at(2), v});
        };
        switch (i.op) {
        case OpDecorate:
            if (i.at(2) != DecorationSpecId && !(i.at(2) == DecorationNoContraction && gone[id(i.at(1))]))
                as(i.op);
            break;
        case OpSpecConstantTrue:
        case OpSpecConstantFalse:
        case OpSpecConstant:
            if (const Value v = value(i.at(2)))
                known(*v);
            else // of another type
                out[as(OpConstant) + 3] = specialised(i.at(2), i.at(3));
            break;
        case OpSpecConstantOp:
            if (const Value v = value(i.at(2)))
                known(*v);
            else
                as(i.op);
            break;
        case OpSpecConstantComposite: as(OpConstantComposite); break;
        default: as(i.op);
        }
    }

    void write(const Function& f, std::array<std::uint32_t, 2> bools, std::vector<std::uint32_t>& out) const {
        const auto put = [&](Words words) { out.insert(out.end(), words.begin(), words.end()); };
        put(f.head.words);
        for (const Instruction& p : f.parameters)
            put(p.words);
        // What comes from blocks that are not reached has no value, and needs an id all the same.
        std::vector<std::uint32_t> named;
        for (const Block& b : f.blocks)
            for (const Instruction& i : b.body)
                if (b.reached && i.op == OpPhi)
                    for (std::size_t k = 3; k + 1 < i.words.size(); k += 2)
                        if (!f.blocks[f.placeOf(i.words[k + 1])].reached)
                            named.push_back(i.words[k]);
        for (const Block& b : f.blocks) {
            out.insert(out.end(), {2u << 16 | OpLabel, b.label});
            for (const Instruction& i : b.body) {
                const bool last = &i == &b.body.back();
                if (last && i.op == OpBranchConditional) {
                    put(i.words);
                    if (const Value condition = b.reached ? value(i.at(1)) : Value(0))
                        out[out.size() - i.words.size() + 1] = bools[*condition];
                } else if (b.reached || i.op == OpSelectionMerge || i.op == OpLoopMerge || (last && i.op == OpBranch)) {
                    put(i.words);
                } else if (last) {
                    out.push_back(1u << 16 | OpUnreachable);
                } else if (hasResult(i) && std::find(named.begin(), named.end(), i.words[2]) != named.end()) {
                    out.insert(out.end(), {3u << 16 | OpUndef, i.words[1], i.words[2]});
                }
            }
        }
        out.push_back(1u << 16 | OpFunctionEnd);
    }

    const Words words_, constants_;
    // By id.
    std::vector<Value> values_;
    std::vector<Kind> kinds_;
    std::vector<Value> specIds_;          // of constants that can be specialised
    std::vector<std::size_t> functionOf_; // kNone: it is none
    std::vector<Instruction> globals_; // before the first function
    std::vector<Function> functions_;
    std::uint32_t entry_ = 0, boolType_ = 0;
    bool changed_ = false;
};

} // namespace

std::vector<std::uint32_t> prune(std::span<const std::uint32_t> spirv, std::span<const std::uint32_t> constants) {
    Pruning pruning(spirv, constants);
    pruning.follow();
    return pruning.result();
}

} // namespace cmpg
