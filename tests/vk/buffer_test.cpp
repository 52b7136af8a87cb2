// Buffers: transfers, accounting, failures.
#include "base/error.h"
#include "devices.h"
#include "support/environment.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cmpg {
namespace {

std::vector<std::uint32_t> counting(std::size_t count) {
    std::vector<std::uint32_t> v(count);
    std::iota(v.begin(), v.end(), 1u);
    return v;
}

void roundTrip(Device& device) {
    // Longer than the staging buffer, and no multiple of it.
    const auto data = counting(5'000'001);
    Buffer buffer(device, "round trip", data.size() * 4 + 64, MemoryKind::Transient);
    EXPECT_EQ(buffer.size() % 16, 0u);
    EXPECT_EQ(buffer.downloadAll<std::uint32_t>(data.size()), std::vector<std::uint32_t>(data.size(), 0));
    buffer.uploadAll(data, 12);
    EXPECT_EQ(buffer.downloadAll<std::uint32_t>(data.size(), 12), data);
    EXPECT_EQ(buffer.downloadAll<std::uint32_t>(3), std::vector<std::uint32_t>(3, 0));
    EXPECT_THROW(buffer.uploadAll(data, 128), std::out_of_range);
}

TEST(Buffer, RoundTrip) { roundTrip(test::device()); }

using test::Environment;

// A device whose memory the host does not map.
Device stagingDevice() {
    const Environment staging("CMPG_STAGING", "1");
    return Device({});
}

TEST(Buffer, RoundTripThroughStaging) {
    Device device = stagingDevice();
    roundTrip(device);
}

// Uploads wait for a submission: in their order, whatever happens to their buffer before it.
TEST(Buffer, UploadsThatWaitKeepTheirOrder) {
    Device device = stagingDevice();
    constexpr std::size_t kCount = 1000;
    Buffer buffer(device, "order", 4 * kCount, MemoryKind::Transient);
    std::vector<std::uint32_t> expected(kCount, 0);
    for (std::uint32_t i = 0; i < 300; ++i) { // each covers a part of the one before
        const std::vector<std::uint32_t> part(200, i + 1);
        const std::size_t at = 7 * i % (kCount - part.size());
        buffer.uploadAll(part, 4 * at);
        std::copy(part.begin(), part.end(), expected.begin() + std::ptrdiff_t(at));
        if (i % 100 == 50)
            Buffer(device, "gone", 64, MemoryKind::Transient); // cleared by a command that waits as well, and is submitted before it goes
    }
    Buffer moved = std::move(buffer);
    EXPECT_EQ(moved.downloadAll<std::uint32_t>(kCount), expected);
}

void manyDownloads(Device& device) {
    const auto data = counting(1'500'000); // two of them are longer than the staging buffer
    std::vector<Buffer> buffers;
    std::vector<std::vector<std::uint32_t>> found;
    for (const std::size_t count : {data.size(), std::size_t(3), data.size(), std::size_t(1), std::size_t(0), data.size()}) {
        Buffer& buffer = buffers.emplace_back(device, "one of many", 4 * data.size(), MemoryKind::Transient);
        buffer.uploadAll(data);
        found.emplace_back(count);
    }
    std::vector<Download> downloads;
    for (std::size_t i = 0; i < buffers.size(); ++i)
        downloads.push_back({&buffers[i], std::as_writable_bytes(std::span(found[i])), std::min<std::size_t>(4 * i, 4 * (data.size() - found[i].size()))});
    download(downloads);
    for (std::size_t i = 0; i < buffers.size(); ++i)
        for (std::size_t k = 0; k < found[i].size(); ++k)
            ASSERT_EQ(found[i][k], data[downloads[i].offset / 4 + k]) << i << ' ' << k;
    downloads.front().offset = 16;
    EXPECT_THROW(download(downloads), std::out_of_range);
}

TEST(Buffer, ManyDownloadsAtOnce) { manyDownloads(test::device()); }

TEST(Buffer, ManyDownloadsAtOnceThroughStaging) {
    Device device = stagingDevice();
    manyDownloads(device);
}

TEST(Buffer, MemoryAccounting) {
    Device device({});
    EXPECT_EQ(device.memory().current, 0u);
    // Allocations may be rounded up, by at most a page here.
    const auto about = [](std::uint64_t actual, std::uint64_t bytes) { return actual >= bytes && actual <= bytes + 4096; };
    {
        const Buffer scene(device, "scene", 1 << 20, MemoryKind::Scene, Texel::Rgba32f);
        EXPECT_PRED2(about, device.memory().byKind[0], std::uint64_t(1) << 20);
        Buffer a(device, "pool", 1 << 16, MemoryKind::Transient);
        const Buffer b(device, "pool", 1 << 17, MemoryKind::Transient);
        EXPECT_PRED2(about, device.memory().buffers.at("pool"), std::uint64_t(3) << 16);
        const std::uint64_t both = device.memory().byKind[2];
        a = Buffer(device, "other", 1 << 10, MemoryKind::Parameters); // the new one exists before the old one goes
        EXPECT_PRED2(about, device.memory().buffers.at("pool"), std::uint64_t(1) << 17);
        EXPECT_EQ(device.memory().peakByKind[2], both);
        EXPECT_EQ(device.memory().byKind[0] + device.memory().byKind[1] + device.memory().byKind[2], device.memory().current);
        EXPECT_GE(device.memory().peak, device.memory().current);
    }
    EXPECT_EQ(device.memory().current, 0u);
    EXPECT_TRUE(device.memory().buffers.empty());
    EXPECT_PRED2(about, device.memory().peak, (std::uint64_t(1) << 20) + (3 << 16) + (1 << 10));
}

TEST(Buffer, FailingAllocation) {
    Device& device = test::device();
    const std::uint64_t before = device.memory().current;
    try {
        const Buffer huge(device, "enormous tape", std::uint64_t(1) << 44, MemoryKind::Transient);
        FAIL() << "16 TiB were allocated";
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Device);
        EXPECT_NE(std::string(error.what()).find("enormous tape"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("17592186044416"), std::string::npos);
        EXPECT_NE(error.remedy.find("memory budget"), std::string::npos);
        EXPECT_EQ(error.options, std::vector<std::string>{"memory"});
    }
    EXPECT_EQ(device.memory().current, before);
}

} // namespace
} // namespace cmpg
