// Specialised kernels on disk: what is found is what was made, and whatever is not is made anew.
#include "support/environment.h"
#include "support/temp_folder.h"
#include "vk/kernel_cache.h"
#include "vk/kernel_file.h"
#include "vk/specialize.h"
#include "vk/spirv.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::uint32_t>;
using Bytes = std::vector<std::uint8_t>;

class KernelCacheTest : public testing::Test {
  protected:
    static std::array<std::uint32_t, 1> constants(std::uint32_t size) { return {size}; } // the local size of the kernel
    static Words made(std::uint32_t size) { return specialize(module().words, constants(size)); }
    static std::string key(std::uint32_t size) { return kernelKey(module(), constants(size)); }
    static const KernelModule& module() { return findKernel("specialized").full; }
    Words ask(const KernelCache& cache, std::uint32_t size) const { return cache.specialised(module(), constants(size)); }

    static Bytes contents(const fs::path& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write(const fs::path& file, const Bytes& bytes) {
        std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
    }
    std::uint64_t size() const {
        std::uint64_t sum = 0;
        for (const auto& entry : fs::directory_iterator(folder_))
            sum += entry.file_size();
        return sum;
    }

    const test::TempFolder temporary_;
    const fs::path folder_ = temporary_.path();
};

TEST_F(KernelCacheTest, FindsWhatWasMade) {
    const KernelCache cache(folder_ / "a/b");
    EXPECT_EQ(ask(cache, 64), made(64));
    ASSERT_TRUE(fs::exists(cache.fileOf(key(64))));
    EXPECT_EQ(ask(KernelCache(folder_ / "a/b"), 64), made(64));
    EXPECT_EQ(ask(cache, 128), made(128));
    EXPECT_NE(made(64), made(128));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "a/b"), {}), 2);
    // That it is found, and not made again: other code under the same key.
    write(cache.fileOf(key(64)), encodeKernel(key(64), made(128)));
    EXPECT_EQ(ask(cache, 64), made(128));
}

TEST_F(KernelCacheTest, KeysAreAllThatCodeIsMadeOf) {
    const KernelModule other{module().words, findKernel("specialized").portable.digest};
    EXPECT_EQ(module().digest.size(), 64u);
    EXPECT_NE(key(64), key(65));
    EXPECT_NE(key(64), kernelKey(module(), std::array<std::uint32_t, 2>{64, 0}));
    EXPECT_NE(key(64), kernelKey(other, constants(64)));
    EXPECT_NE(key(64).find(specializerVersion()), std::string::npos);
}

TEST_F(KernelCacheTest, EveryKernelHasADigestOfItsOwn) {
    std::vector<std::string_view> digests;
    for (const EmbeddedKernel& kernel : embeddedKernels())
        for (const KernelModule* m : {&kernel.full, &kernel.cpu, &kernel.portable})
            if (std::ranges::none_of(digests, [&](std::string_view d) { return d == m->digest; }))
                digests.push_back(m->digest);
    EXPECT_EQ(digests.size(), 3 * embeddedKernels().size()); // the digest has the name of the variant in it
}

TEST_F(KernelCacheTest, EveryTruncationAndFlippedBitIsIgnored) {
    Bytes bytes = encodeKernel(key(64), made(64));
    ASSERT_EQ(decodeKernel(bytes, key(64)), made(64));
    for (std::size_t length = 0; length < bytes.size(); ++length)
        EXPECT_FALSE(decodeKernel(std::span(bytes).first(length), key(64))) << length;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        bytes[bit / 8] ^= std::uint8_t(1 << bit % 8);
        EXPECT_FALSE(decodeKernel(bytes, key(64))) << bit;
        bytes[bit / 8] ^= std::uint8_t(1 << bit % 8);
    }
    bytes.push_back(0);
    EXPECT_FALSE(decodeKernel(bytes, key(64)));
}

TEST_F(KernelCacheTest, WrongCodeUnderARightChecksumIsIgnored) {
    const Words code = made(64);
    Words overrun = code;
    overrun[5] |= 0xffff0000; // the length of the first instruction
    for (const Words& wrong : {Words(), Words(code.begin() + 1, code.end()), Words(code.begin(), code.begin() + 4), overrun})
        EXPECT_FALSE(decodeKernel(encodeKernel(key(64), wrong), key(64)));
}

TEST_F(KernelCacheTest, DamagedAndSwappedFilesAreMadeAnew) {
    const KernelCache cache(folder_);
    ask(cache, 64), ask(cache, 128);
    const fs::path file = cache.fileOf(key(64));
    const Bytes whole = contents(file);
    const auto madeAnew = [&] {
        EXPECT_EQ(ask(cache, 64), made(64));
        EXPECT_EQ(contents(file), whole);
    };
    fs::copy_file(cache.fileOf(key(128)), file, fs::copy_options::overwrite_existing);
    madeAnew();
    write(file, Bytes(whole.begin(), whole.end() - 10));
    madeAnew();
    write(file, {});
    madeAnew();
    write(file, Bytes(17 << 20, 0));
    madeAnew();
    fs::remove(file);
    ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
    madeAnew();
    if (::geteuid() == 0) { // of another user
        write(file, encodeKernel(key(64), made(128)));
        ASSERT_EQ(::chown(file.c_str(), 1, 1), 0);
        madeAnew();
    }
    fs::remove(file); // what cannot be replaced stays
    fs::create_directory(file);
    EXPECT_EQ(ask(cache, 64), made(64));
    EXPECT_TRUE(fs::is_directory(file));
}

TEST_F(KernelCacheTest, OldestGoBeyondTheBound) {
    const std::uint64_t one = encodeKernel(key(1), made(1)).size(), bound = 3 * one + one / 2;
    write(folder_ / "notes.txt", Bytes(std::size_t(2 * bound), 0)); // not the cache's
    const KernelCache cache(folder_, bound);
    using namespace std::chrono_literals;
    for (std::uint32_t i = 1; i <= 3; ++i) {
        ask(cache, i);
        fs::last_write_time(cache.fileOf(key(i)), fs::file_time_type::clock::now() - 1h + i * 1min);
    }
    ask(cache, 1); // used again
    ask(cache, 4);
    EXPECT_TRUE(fs::exists(cache.fileOf(key(1))) && fs::exists(cache.fileOf(key(4))));
    EXPECT_FALSE(fs::exists(cache.fileOf(key(2))));
    for (std::uint32_t i = 5; i < 40; ++i) {
        ask(cache, i);
        EXPECT_LE(size() - 2 * bound, bound);
    }
    EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
    EXPECT_EQ(ask(KernelCache(folder_ / "small", one / 2), 1), made(1)); // larger than all there may be
    EXPECT_FALSE(fs::exists(folder_ / "small"));
}

TEST_F(KernelCacheTest, ManyAtOnce) {
    constexpr std::uint32_t kKernels = 6;
    const std::uint64_t bound = 3 * encodeKernel(key(1), made(1)).size();
    std::vector<Words> expected;
    for (std::uint32_t i = 0; i < kKernels; ++i)
        expected.push_back(made(i + 1));
    std::atomic<int> wrong = 0;
    {
        std::vector<std::jthread> threads;
        for (std::uint32_t t = 0; t < 4; ++t)
            threads.emplace_back([&, t] {
                const KernelCache cache(folder_, bound); // files come and go
                for (std::uint32_t i = 0; i < 60; ++i)
                    wrong += ask(cache, (i + t) % kKernels + 1) != expected[(i + t) % kKernels];
            });
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_LE(size(), bound);
    for (const auto& entry : fs::directory_iterator(folder_))
        EXPECT_EQ(entry.path().extension(), ".spirv"); // nothing half written stays
}

TEST_F(KernelCacheTest, WithoutAFolderCodeIsMade) {
    write(folder_ / "file", {1});
    for (const fs::path& folder : {fs::path(), folder_ / "file", folder_ / "file/below", fs::path("/proc/cmpg-vk")})
        EXPECT_EQ(ask(KernelCache(folder), 64), made(64)) << folder;
    fs::create_directory(folder_ / "locked");
    fs::permissions(folder_ / "locked", fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_EQ(ask(KernelCache(folder_ / "locked"), 64), made(64));
}

TEST(KernelCacheFolder, FollowsTheEnvironment) {
    const auto folder = [](const std::array<const char*, 3>& values) {
        const test::Environment own("CMPG_CACHE", values[0]), caches("XDG_CACHE_HOME", values[1]), home("HOME", values[2]);
        return KernelCache::folderFromEnvironment();
    };
    EXPECT_EQ(folder({"", "", "/home/a"}), "/home/a/.cache/cmpg-vk");
    EXPECT_EQ(folder({"", "/caches", "/home/a"}), "/caches/cmpg-vk");
    EXPECT_EQ(folder({"", "caches", "/home/a"}), "/home/a/.cache/cmpg-vk"); // relative
    EXPECT_EQ(folder({"/mine", "/caches", "/home/a"}), "/mine");
    EXPECT_EQ(folder({"0", "/caches", "/home/a"}), "");
    EXPECT_EQ(folder({"", "", ""}), "");
}

} // namespace
} // namespace cmpg
