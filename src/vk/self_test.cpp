// The known answers of shaders/self_test.comp, and what to say where a device has others.
#include "vk/self_test.h"

#include "shared/bindings.h"
#include "shared/self_test.h"
#include "vk/impl.h"

#include <algorithm>
#include <mutex>
#include <set>
#include <utility>

namespace cmpg {

namespace {

using namespace gpu;

constexpr uint kNodes = 2 * kSelfTestInner + 1, kVectors = 13, kNumbers = 11, kWords = 7;

// Small whole numbers, so that every sum and product is exact.
struct Input {
    std::vector<uvec4> nodes;
    std::vector<vec4> vectors;
    std::vector<float> numbers;
    std::vector<uint> words;

    Input() {
        for (uint i = 0; i < kNodes; ++i)
            nodes.push_back(i < kSelfTestInner ? uvec4(2 * i + 1, 0, 0, 0) : uvec4(0, i % kVectors, i % kNumbers, i % kWords));
        for (uint i = 0; i < kVectors; ++i)
            vectors.emplace_back(float(i + 1), float(5 * i) - 20.f, float(i * i), 1000.f);
        for (uint i = 0; i < kNumbers; ++i)
            numbers.push_back(float(3 * i) - 7.f);
        for (uint i = 0; i < kWords; ++i)
            words.push_back(0x1234567u * (i + 1));
    }
};

struct Output {
    SelfTestCounts counts{};
    std::uint64_t sum = 0;
    std::vector<SelfTestResult> results = std::vector<SelfTestResult>(kSelfTestItems); // by item; those that leave none stay zero
};

// As in the kernel.
uint hash(uint item, uint node) {
    uint h = item * 0x9e3779b1u + node * 0x85ebca6bu;
    h ^= h >> 15;
    return h * 0x2c1b3c6du;
}

void visit(const Input& in, uint index, SelfTestResult& result) {
    ++result.visits;
    const uvec4 node = in.nodes[index];
    if (node.x == 0) {
        result.sum += vec3(in.vectors[node.y]) * in.numbers[node.z];
        result.words ^= in.words[node.w];
    } else {
        for (uint child = node.x; child < node.x + 2; ++child)
            if (hash(result.item, child) < 0xc0000000u)
                visit(in, child, result);
    }
}

Output expected(const Input& in) {
    Output out;
    out.counts.items = kSelfTestItems;
    out.counts.groups = uvec3((kSelfTestItems + 63) / 64, 1, 1);
    for (uint item = 0; item < kSelfTestItems; ++item) {
        SelfTestResult result{item, vec3(0), 0, 0};
        visit(in, 0, result);
        out.counts.visits += result.visits;
        out.sum += std::uint64_t(item) << 32 | hash(item, 0);
        if (result.visits % 2 == 0)
            continue;
        ++out.counts.places;
        out.results[item] = result;
    }
    return out;
}

template <class T> Buffer texels(Device& device, const std::vector<T>& values, Texel texel) {
    Buffer buffer(device, "self-test", values.size() * sizeof(T), MemoryKind::Scene, texel);
    buffer.uploadAll(values);
    return buffer;
}

Output computed(Device& device, const Input& in) {
    const Kernel kernel(device, "self_test");
    const Buffer nodes = texels(device, in.nodes, Texel::Rgba32ui), vectors = texels(device, in.vectors, Texel::Rgba32f),
                 numbers = texels(device, in.numbers, Texel::R32f), words = texels(device, in.words, Texel::R32ui);
    const Buffer counts(device, "self-test", sizeof(SelfTestCounts), MemoryKind::Transient), sum(device, "self-test", 8, MemoryKind::Transient),
        results(device, "self-test", kSelfTestItems * sizeof(SelfTestResult), MemoryKind::Transient);
    Bindings bindings;
    bindings.set(kBindTestNodes, nodes).set(kBindTestVectors, vectors).set(kBindTestNumbers, numbers).set(kBindTestWords, words);
    bindings.set(kBindTestCounts, counts).set(kBindTestCountsHere, counts).set(kBindTestSum, sum).set(kBindTestResults, results);
    Commands commands(device);
    commands.dispatch(kernel, bindings, kSelfTestItems, SelfTestPush{kSelfTestCompute, 0}); // of no items yet: what a cache holds then must not last
    commands.barrier();
    commands.dispatch(kernel, bindings, 1, SelfTestPush{kSelfTestPrepare, kSelfTestItems});
    commands.barrier();
    commands.dispatchIndirect(kernel, bindings, counts, 0, SelfTestPush{kSelfTestCompute, kSelfTestItems});
    commands.submitAndWait();

    Output out;
    out.counts = counts.downloadAll<SelfTestCounts>(1).front();
    out.sum = sum.downloadAll<std::uint64_t>(1).front();
    for (const SelfTestResult& result : results.downloadAll<SelfTestResult>(std::min(out.counts.places, kSelfTestItems)))
        if (result.item < kSelfTestItems)
            out.results[result.item] = result;
    return out;
}

// What differs, or nothing.
std::string difference(const Output& found, const Output& wanted) {
    const auto differs = [](const char* what, std::uint64_t is, std::uint64_t was) {
        return is == was ? std::string() : std::string(what) + " (" + std::to_string(is) + ", not " + std::to_string(was) + "), ";
    };
    std::string text = differs("group counts", found.counts.groups.x, wanted.counts.groups.x) +
                       differs("places in a queue", found.counts.places, wanted.counts.places) +
                       differs("sums over subgroups", found.counts.visits, wanted.counts.visits) +
                       differs("64-bit sums", found.sum, wanted.sum);
    uint wrong = 0;
    for (uint i = 0; i < kSelfTestItems; ++i) {
        const SelfTestResult &a = found.results[i], &b = wanted.results[i];
        wrong += a.item != b.item || a.sum != b.sum || a.words != b.words || a.visits != b.visits;
    }
    text += differs("reads in a loop", kSelfTestItems - wrong, kSelfTestItems);
    return text.empty() ? text : text.substr(0, text.size() - 2);
}

Error refusal(const Device::Impl& device, const std::string& wrong) {
    std::string cause = "its driver, " + device.info.driver + ", fails the test of a device that is opened: " + wrong;
    std::string remedy = "install another version of the driver, or choose another device, also by VK_ICD_FILENAMES";
    if (isLavapipe(device.physical)) {
        cause += "; Mesa 25 takes compiled code from its cache on disk even where it was compiled for another LP_NATIVE_VECTOR_WIDTH";
        remedy = "unset LP_NATIVE_VECTOR_WIDTH and delete Mesa's cache (mesa_shader_cache* in ~/.cache, or where MESA_SHADER_CACHE_DIR says), or set "
                 "MESA_SHADER_CACHE_DISABLE=true; otherwise " +
                 remedy;
    }
    return Error(ErrorKind::Device, "'" + device.info.name + "' computes wrong results and cannot be used", cause, remedy, {"device"});
}

} // namespace

void selfTest(Device& device) {
    Device::Impl& impl = device.impl();
    static std::mutex mutex;
    static std::set<std::string> passed; // what a driver does does not change within a process
    const std::string key = impl.info.name + '\n' + impl.info.driver + '\n' + std::to_string(int(impl.variant));
    const std::lock_guard lock(mutex);
    if (!impl.fault.wrongResults && passed.contains(key))
        return;

    const Fault fault = std::exchange(impl.fault, {});
    const MemoryUse memory = impl.memory;
    const Input input;
    Output found = computed(device, input);
    impl.fault = fault;
    impl.memory = memory;
    impl.kernelTimes.clear();
    if (fault.wrongResults)
        found.results.back().sum += 1.f, found.results.back().item = kSelfTestItems - 1;
    if (const std::string wrong = difference(found, expected(input)); !wrong.empty())
        throw refusal(impl, wrong);
    passed.insert(key);
}

} // namespace cmpg
