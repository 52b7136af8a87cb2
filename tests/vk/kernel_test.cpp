// Kernels: bindings, folded and indirect dispatch, atomics, specialization, timestamps.
#include "base/error.h"
#include "base/stopwatch.h"
#include "devices.h"
#include "vk/impl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <random>

namespace cmpg {
namespace {

struct Count {
    std::uint32_t count;
};

template <class T> std::vector<T> run(Device& device, const Kernel& kernel, const Bindings& bindings, const Buffer& result,
                                      std::uint32_t items, std::size_t count) {
    Commands commands(device);
    commands.dispatch(kernel, bindings, items, Count{items});
    commands.submitAndWait();
    return result.downloadAll<T>(count);
}

void copyTexels(Device& device) {
    constexpr std::uint32_t count = 1000, offset = 512; // bytes skipped by the binding
    const Kernel kernel(device, "copy_texels");
    std::vector<std::uint32_t> bits(4 * count);
    std::mt19937 random(1);
    for (auto& b : bits)
        b = random() & 0x7f7fffffu; // finite as a float, not a signalling NaN that a load may change
    Bindings bindings;
    std::vector<Buffer> in, out;
    const std::array texels{Texel::Rgba32f, Texel::Rgba32ui, Texel::R32f, Texel::R32ui};
    for (std::uint32_t i = 0; i < 4; ++i) {
        in.emplace_back(device, "in", 16 * count, MemoryKind::Scene, texels[i]);
        in.back().uploadAll(bits);
        out.emplace_back(device, "out", 16 * count, MemoryKind::Scene, texels[i]);
    }
    const std::uint32_t items = count - offset / 16; // the vec4 views are the shortest
    for (std::uint32_t i = 0; i < 4; ++i)
        bindings.set(i, in[i], offset, i % 2 ? 16 * items : 0).set(4 + i, out[i]);
    run<std::uint32_t>(device, kernel, bindings, out[0], items, 1);
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::size_t words = (i < 2 ? 4 : 1) * items;
        const auto expected = std::vector(bits.begin() + offset / 4, bits.begin() + offset / 4 + std::ptrdiff_t(words));
        EXPECT_EQ(out[i].downloadAll<std::uint32_t>(words), expected) << "format " << i;
    }
}

TEST(Kernel, ReadsTexels) { copyTexels(test::device()); }
TEST(Kernel, ReadsStorageWherePortable) { copyTexels(test::portableDevice()); }

TEST(Kernel, RefusesTexelsOfAnotherFormat) {
    if (test::device().portable())
        GTEST_SKIP() << "kernels read no texels on this device";
    const Kernel kernel(test::device(), "copy_texels");
    const Buffer wrong(test::device(), "wrong", 64, MemoryKind::Scene, Texel::Rgba32ui);
    const Buffer none(test::device(), "none", 64, MemoryKind::Scene);
    Commands commands(test::device());
    EXPECT_THROW(commands.dispatch(kernel, Bindings().set(0, wrong), 1, Count{1}), std::logic_error);
    EXPECT_THROW(commands.dispatch(kernel, Bindings().set(0, none), 1, Count{1}), std::logic_error);
}

TEST(Kernel, FoldsManyWorkgroups) {
    Device& device = test::device();
    const Kernel kernel(device, "write_index");
    ASSERT_EQ(kernel.localSize(), 64u);
    // Up to 65 535 workgroups of 64 in one row, then two and three rows, the last ones incomplete.
    for (const std::uint32_t items : {1u, 64u, 65u, 65535u * 64, 65535u * 64 + 1, 65535u * 128 + 7}) {
        const Buffer result(device, "result", 4ull * items, MemoryKind::Transient);
        const auto visits = run<std::uint32_t>(device, kernel, Bindings().set(0, result), result, items, items);
        EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](std::uint32_t n) { return n == 1; })) << items << " items";
    }
    Commands commands(device);
    EXPECT_THROW(commands.dispatch(kernel, {}, std::uint64_t(1) << 32, Count{0}), std::logic_error);
}

TEST(Kernel, DispatchesIndirectly) {
    Device& device = test::device();
    const Kernel kernel(device, "write_index");
    const Buffer result(device, "result", 4 * 64 * 6, MemoryKind::Transient);
    Buffer arguments(device, "arguments", 32, MemoryKind::Transient);
    arguments.uploadAll(std::vector<std::uint32_t>{9, 9, 9, 9, 2, 3, 1});
    Commands commands(device);
    commands.dispatchIndirect(kernel, Bindings().set(0, result), arguments, 16, Count{64 * 6 - 1});
    commands.submitAndWait();
    std::vector<std::uint32_t> expected(64 * 6, 1);
    expected.back() = 0;
    EXPECT_EQ(result.downloadAll<std::uint32_t>(64 * 6), expected);
    commands.submitAndWait(); // recorded once, submitted twice
    EXPECT_EQ(result.downloadAll<std::uint32_t>(1).front(), 2u);
    EXPECT_THROW(commands.dispatchIndirect(kernel, {}, arguments, 24, Count{0}), std::logic_error);
}

TEST(Kernel, GroupCountsGrowOnTheDevice) {
    Device& device = test::device();
    const Kernel grow(device, "grow_groups"), write(device, "write_index");
    for (const std::uint32_t invocations : {0u, 1u, 22u, 64u, 1000u, 100000u}) {
        std::uint32_t taken = 0; // an invocation takes 0 to 6 places
        for (std::uint32_t i = 0; i < invocations; ++i)
            taken += i % 7;
        Buffer queue(device, "queue", 16, MemoryKind::Transient);
        queue.uploadAll(std::vector<std::uint32_t>{0, 1, 1, 0});
        const Buffer result(device, "result", 4ull * taken + 4, MemoryKind::Transient);
        Commands commands(device);
        commands.dispatch(grow, Bindings().set(0, queue), invocations, Count{invocations});
        commands.barrier();
        commands.dispatchIndirect(write, Bindings().set(0, result), queue, 0, Count{taken});
        commands.submitAndWait();
        EXPECT_EQ(queue.downloadAll<std::uint32_t>(4), (std::vector<std::uint32_t>{(taken + 63) / 64, 1, 1, taken})) << invocations;
        std::vector<std::uint32_t> expected(taken, 1);
        expected.push_back(0);
        EXPECT_TRUE(result.downloadAll<std::uint32_t>(taken + 1) == expected) << invocations;
    }
}

TEST(Kernel, BindsPartsOfLargeBuffers) {
    Device& device = test::device();
    const std::uint64_t limit = device.info().maxStorageBufferRange;
    if (limit > (std::uint64_t(256) << 20))
        GTEST_SKIP() << "the device binds " << limit << " bytes at once";
    const Kernel kernel(device, "write_index");
    const Buffer large(device, "large", limit + 4096, MemoryKind::Transient);
    Commands commands(device);
    try {
        commands.dispatch(kernel, Bindings().set(0, large), 64, Count{64});
        FAIL() << "more than the limit was bound";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Device);
        EXPECT_NE(std::string(error.what()).find("large"), std::string::npos);
    }
    commands.dispatch(kernel, Bindings().set(0, large, limit, 4096), 64, Count{64});
    commands.submitAndWait();
    EXPECT_EQ(large.downloadAll<std::uint32_t>(64, limit), std::vector<std::uint32_t>(64, 1));
    EXPECT_THROW(commands.dispatch(kernel, Bindings().set(0, large, limit, 8192), 64, Count{64}), std::logic_error);
}

void sumFixed(Device& device) {
    constexpr std::uint32_t count = 100'000;
    std::mt19937_64 random(2);
    std::vector<std::uint64_t> numbers(count);
    std::uint64_t expected = 0;
    for (auto& n : numbers)
        expected += n = std::uint64_t(std::int64_t(random()) >> 20); // both signs, so that carries and borrows occur
    Buffer in(device, "numbers", 8 * count, MemoryKind::Transient);
    const Buffer sum(device, "sum", 8, MemoryKind::Transient);
    in.uploadAll(numbers);
    const Kernel kernel(device, "sum_fixed");
    EXPECT_EQ(run<std::uint64_t>(device, kernel, Bindings().set(0, in).set(1, sum), sum, count, 1).front(), expected);
}

TEST(Kernel, SumsFixedPoint) { sumFixed(test::device()); }
TEST(Kernel, SumsFixedPointWherePortable) { sumFixed(test::portableDevice()); }

TEST(Kernel, Specializes) {
    struct Empty {};
    Device& device = test::device();
    const Buffer result(device, "result", 16, MemoryKind::Transient);
    const auto values = [&](std::span<const std::uint32_t> constants) {
        const Kernel kernel(device, "specialized", constants);
        Commands commands(device);
        commands.dispatch(kernel, Bindings().set(9, result), 1, Empty{});
        commands.submitAndWait();
        auto words = result.downloadAll<std::uint32_t>(4);
        words.push_back(kernel.localSize());
        return words;
    };
    EXPECT_EQ(values({}), (std::vector<std::uint32_t>{32, 0, std::bit_cast<std::uint32_t>(1.5f), 7, 32}));
    const std::array<std::uint32_t, 6> constants{16, 1, std::bit_cast<std::uint32_t>(-2.f), 99, 5, 99};
    EXPECT_EQ(values(constants), (std::vector<std::uint32_t>{16, 1, std::bit_cast<std::uint32_t>(-2.f), 5, 16}));
}

TEST(Kernel, RefusesOtherPushConstants) {
    struct Large {
        std::uint32_t words[6];
    };
    const Kernel kernel(test::device(), "write_index");
    Commands commands(test::device());
    EXPECT_THROW(commands.dispatch(kernel, {}, 1, std::uint8_t(0)), std::logic_error);
    EXPECT_THROW(commands.dispatch(kernel, {}, 1, Large{}), std::logic_error);
}

TEST(Kernel, ManyDispatchesInOneSubmission) {
    // More than one pool of descriptor sets and queries holds.
    constexpr std::uint32_t dispatches = 1000;
    Device& device = test::device();
    const Kernel kernel(device, "write_index");
    const Buffer result(device, "result", 256, MemoryKind::Transient);
    device.resetKernelTimes();
    for (int round = 1; round <= 2; ++round) {
        device.timeKernels(round == 2);
        Commands commands(device);
        for (std::uint32_t i = 0; i < dispatches; ++i) {
            commands.dispatch(kernel, Bindings().set(0, result), 64, Count{64});
            commands.barrier();
        }
        commands.submitAndWait();
        EXPECT_EQ(result.downloadAll<std::uint32_t>(64), std::vector<std::uint32_t>(64, round * dispatches));
        EXPECT_EQ(device.kernelTimes().at("write_index").calls, round * dispatches);
        EXPECT_EQ(device.kernelTimes().at("write_index").seconds > 0, round == 2);
    }
    device.timeKernels(false);
}

TEST(Kernel, Timestamps) {
    Device& device = test::device();
    const Kernel kernel(device, "count_iterations");
    Buffer result(device, "result", 8, MemoryKind::Transient);
    device.resetKernelTimes();
    device.timeKernels(true);
    const auto seconds = [&](std::uint32_t items) {
        const double before = device.kernelTimes().contains("count_iterations") ? device.kernelTimes().at("count_iterations").seconds : 0;
        Commands commands(device);
        commands.dispatch(kernel, Bindings().set(0, result), items, Count{30000});
        const Stopwatch watch;
        commands.submitAndWait();
        const double wall = watch.seconds();
        const double measured = device.kernelTimes().at("count_iterations").seconds - before;
        EXPECT_LE(measured, wall);
        return measured;
    };
    seconds(8); // compiles
    // A thousand times the work takes longer, however busy the machine is.
    EXPECT_GT(seconds(8000), seconds(8));
    EXPECT_EQ(device.kernelTimes().at("count_iterations").calls, 3u);
    device.timeKernels(false);
}

TEST(Kernel, WarmUpTouchesNothing) {
    Device device({});
    const Kernel kernel(device, "write_index");
    const Buffer result(device, "result", 256, MemoryKind::Transient);
    const double before = device.compileSeconds();
    EXPECT_GT(before, 0);
    const std::array kernels{&kernel};
    warmUp(device, kernels);
    warmUp(device, kernels, Bindings().set(0, result));
    EXPECT_EQ(result.downloadAll<std::uint32_t>(64), std::vector<std::uint32_t>(64, 0));
    EXPECT_GT(device.compileSeconds(), before);
    EXPECT_TRUE(device.kernelTimes().empty());
}

TEST(Kernel, IsSharedByAllWhoseCodeIsTheSame) {
    Device device{Device::Options{}};
    const Kernel first(device, "specialized", std::array{64u, 1u, 0u, 0u, 7u}), second(device, "specialized", std::array{64u, 1u, 0u, 0u, 7u});
    const Kernel unused(device, "specialized", std::array{64u, 1u, 0u, 9u, 7u}); // it has no constant 3
    const Kernel other(device, "specialized", std::array{64u, 1u, 0u, 0u, 8u});
    EXPECT_EQ(second.impl(), first.impl());
    EXPECT_EQ(unused.impl(), first.impl());
    EXPECT_NE(other.impl(), first.impl());
}

TEST(Kernel, IsKeptForOthersOnceAskedFor) {
    Device device{Device::Options{}};
    device.keepKernels();
    const Kernel::Impl* const kept = Kernel(device, "gather_film").impl();
    EXPECT_EQ(Kernel(device, "gather_film").impl(), kept); // outlives the kernel that had it made
}

TEST(Kernel, SeveralAreMadeSideBySide) {
    Device device{Device::Options{}};
    std::vector<std::array<std::uint32_t, 5>> constants;
    for (std::uint32_t i = 0; i < 24; ++i)
        constants.push_back({64, 0, 0, 0, i % 12});
    std::vector<KernelRequest> requests;
    for (const auto& c : constants)
        requests.push_back({"specialized", c});
    const std::vector<Kernel> kernels = makeKernels(device, requests);
    const std::vector<Kernel> again = makeKernels(device, requests);
    for (std::size_t i = 0; i < kernels.size(); ++i) {
        EXPECT_EQ(kernels[i].name(), "specialized");
        EXPECT_NE(kernels[i].impl(), kernels[(i + 1) % kernels.size()].impl());
        EXPECT_TRUE(again[i].impl() == kernels[i].impl() || again[i].impl() == kernels[(i + 12) % 24].impl());
    }
    requests.push_back({"no_such_kernel", {}});
    EXPECT_THROW(makeKernels(device, requests), std::logic_error);
}

// The kernel has 64-bit integers in both variants, which those of the program have in the full one alone.
TEST(Kernel, NamesWhatTheDeviceLacks) {
    const bool known = test::device().impl().physical.getFeatures().shaderInt64;
    try {
        const Kernel kernel(test::device(), "push_layout");
        EXPECT_TRUE(known);
    } catch (const Error& error) {
        EXPECT_FALSE(known);
        EXPECT_EQ(error.kind, ErrorKind::Device);
        EXPECT_NE(std::string(error.what()).find("64-bit integers"), std::string::npos) << error.what();
    }
}

TEST(Kernel, UnknownNameIsRefused) { EXPECT_THROW(Kernel(test::device(), "no_such_kernel"), std::logic_error); }

} // namespace
} // namespace cmpg
