// Device choice, validation, and facts about drivers that the kernels are designed around.
#include "base/error.h"
#include "devices.h"
#include "support/environment.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <unistd.h>

namespace cmpg {
namespace {

using test::Environment;

TEST(Device, ListsAndSelects) {
    const auto devices = Device::list();
    ASSERT_FALSE(devices.empty());
    for (std::size_t i = 0; i < devices.size(); ++i) {
        EXPECT_EQ(devices[i].usable, devices[i].missing.empty());
        if (!devices[i].usable)
            continue;
        EXPECT_EQ(Device({.select = std::to_string(i), .validation = false, .portable = false}).info().name, devices[i].name);
        std::string part = devices[i].name.substr(1);
        part[0] = char(std::toupper(part[0]));
        Device({.select = part, .validation = false, .portable = false});
    }
    try {
        Device({.select = "no such device", .validation = false, .portable = false});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Device);
        EXPECT_NE(error.cause.find(devices[0].name), std::string::npos) << error.cause;
    }
    EXPECT_THROW(Device({.select = std::to_string(devices.size()), .validation = false, .portable = false}), Error);
}

// What a process is told that has no driver but one that does not work.
Error errorWithDriver(const char* manifest) {
    const Environment icd("VK_ICD_FILENAMES", manifest), files("VK_DRIVER_FILES", nullptr);
    try {
        Device::list();
    } catch (const Error& error) {
        return error;
    }
    return Error(ErrorKind::Usage, "a device was found");
}

TEST(Device, SaysWhatToInstallWhenThereIsNone) {
    const Error error = errorWithDriver("/nonexistent/driver.json");
    EXPECT_EQ(error.kind, ErrorKind::Device) << error.what();
    EXPECT_NE(error.cause.find("/nonexistent/driver.json"), std::string::npos) << error.cause;
    EXPECT_NE(error.remedy.find("mesa-vulkan-drivers"), std::string::npos) << error.remedy;
    // The usual folders may have a manifest of NVIDIA's as well.
    EXPECT_EQ(error.remedy.find("libegl1") != std::string::npos, error.cause.find("nvidia") != std::string::npos) << error.remedy;
    EXPECT_NE(errorWithDriver("/nonexistent/nvidia_icd.json").remedy.find("libegl1"), std::string::npos);
}

// A driver that answers every question and computes nothing lacks nearly all that is asked for.
TEST(Device, NamesWhatADeviceLacks) {
    if (!*CMPG_MOCK_DRIVER)
        GTEST_SKIP() << "there is no driver that lacks something: the package chromium-common has one, libVkICD_mock_icd.so";
    const auto manifest = std::filesystem::temp_directory_path() / ("cmpg-driver-" + std::to_string(getpid()) + ".json");
    std::ofstream(manifest) << R"({"file_format_version": "1.0.0", "ICD": {"library_path": ")" << CMPG_MOCK_DRIVER << R"(", "api_version": "1.3.0"}})";
    const Environment icd("VK_ICD_FILENAMES", manifest.c_str()), files("VK_DRIVER_FILES", nullptr);
    const auto devices = Device::list();
    ASSERT_EQ(devices.size(), 1u);
    EXPECT_FALSE(devices[0].usable);
    EXPECT_NE(devices[0].missing.find("scalarBlockLayout"), std::string::npos) << devices[0].missing;
    EXPECT_NE(devices[0].missing.find("subgroup ballot"), std::string::npos) << devices[0].missing;
    for (const char* select : {"", "0"})
        try {
            Device({.select = select, .validation = false, .portable = false});
            FAIL() << "a device that lacks " << devices[0].missing << " was taken";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Device);
            EXPECT_NE((error.what() + error.cause).find(devices[0].missing), std::string::npos) << error.what() << "\n" << error.cause;
        }
    std::filesystem::remove(manifest);
}

TEST(Device, PortableByEnvironment) {
    const Environment portable("CMPG_PORTABLE", "1");
    EXPECT_TRUE(Device({}).portable());
}

TEST(Device, ThreadsOfTheDriver) {
    if (test::device().info().name.find("llvmpipe") == std::string::npos) {
        EXPECT_EQ(test::device().driverThreads(), 1u);
        return;
    }
    const Environment threads("LP_NUM_THREADS", "1");
    EXPECT_EQ(Device({}).driverThreads(), 1u);
}

TEST(Device, ValidationFindsAMissingBarrier) {
    std::unique_ptr<Device> device;
    try {
        device = std::make_unique<Device>(Device::Options{.select = {}, .validation = true, .portable = false});
    } catch (const Error& error) {
        GTEST_SKIP() << error.what();
    }
    const Buffer buffer(*device, "buffer", 64, MemoryKind::Transient);
    const auto writeTwice = [&](bool barrier) {
        Commands commands(*device);
        for (int i = 0; i < 2; ++i) {
            commands.fill(buffer, std::uint32_t(i));
            if (barrier)
                commands.barrier();
        }
        commands.submitAndWait();
    };
    EXPECT_NO_THROW(writeTwice(true));
    try {
        writeTwice(false);
        FAIL() << "two writes without a barrier passed";
    } catch (const Error& error) {
        EXPECT_NE(error.cause.find("WRITE_AFTER_WRITE"), std::string::npos) << error.cause;
    }
}

// Where the layers can look into kernels; drivers themselves let such accesses pass.
TEST(Device, ValidationFindsAnAccessOutOfRange) {
    const Environment kernels("CMPG_VALIDATION", "gpu");
    std::unique_ptr<Device> device;
    try {
        device = std::make_unique<Device>(Device::Options{});
    } catch (const Error& error) {
        GTEST_SKIP() << error.what() << "\n" << error.cause; // the layers need features of their own
    }
    const Kernel kernel(*device, "write_index");
    const Buffer result(*device, "result", 64 * 4, MemoryKind::Transient);
    const auto write = [&](std::uint32_t count) {
        Commands commands(*device);
        commands.dispatch(kernel, Bindings().set(0, result), count, count);
        commands.submitAndWait();
    };
    EXPECT_NO_THROW(write(64));
    try {
        write(65);
        FAIL() << "a write beyond the end passed";
    } catch (const Error& error) {
        EXPECT_NE(error.cause.find("write_index"), std::string::npos) << error.cause;
    }
}

// lavapipe of Mesa 22 ends all loops of an invocation after 65 535 iterations in sum and says nothing; that of Mesa 25 does not. Kernels are
// written with bounds far below that, as long as Debian 12 has Mesa 22.
TEST(Device, OldLavapipeEndsLongLoops) {
    struct Push {
        std::uint32_t count;
    };
    Device& device = test::device();
    const Kernel kernel(device, "count_iterations");
    const Buffer result(device, "result", 8, MemoryKind::Transient);
    const auto iterations = [&](std::uint32_t count) {
        Commands commands(device);
        commands.dispatch(kernel, Bindings().set(0, result), 1, Push{count});
        commands.submitAndWait();
        return result.downloadAll<std::uint32_t>(1).front();
    };
    EXPECT_EQ(iterations(60000), 60000u);
    if (device.info().driver.find("Mesa 22.") == std::string::npos || device.info().name.find("llvmpipe") == std::string::npos)
        EXPECT_EQ(iterations(200000), 200000u);
    else
        EXPECT_LT(iterations(200000), 65600u);
}

} // namespace
} // namespace cmpg
