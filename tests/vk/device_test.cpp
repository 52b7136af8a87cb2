// Device choice, validation, and facts about drivers that the kernels are designed around.
#include "base/error.h"
#include "devices.h"
#include "support/environment.h"
#include "support/processors.h"
#include "support/temp_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <memory>

namespace cmpg {
namespace {

using test::Environment;

TEST(Device, ListsAndSelects) {
    const auto devices = Device::list();
    ASSERT_FALSE(devices.empty());
    const auto upper = [](std::string text) {
        std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
        return text;
    };
    int usable = 0;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (!devices[i].usable) {
            EXPECT_FALSE(devices[i].missing.empty()) << devices[i].name;
            continue;
        }
        ++usable;
        EXPECT_EQ(Device({.select = std::to_string(i), .validation = false, .portable = false}).info().name, devices[i].name);
        const std::string part = upper(devices[i].name.substr(1));
        const std::string found = Device({.select = part, .validation = false, .portable = false}).info().name; // another one, where two are called alike
        EXPECT_NE(upper(found).find(part), std::string::npos) << found;
    }
    EXPECT_GT(usable, 0);
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

TEST(Device, SaysWhatToDoWhenThereIsNone) {
    const Error error = errorWithDriver("/nonexistent/driver.json");
    EXPECT_EQ(error.kind, ErrorKind::Device) << error.what();
    EXPECT_NE(error.cause.find("/nonexistent/driver.json"), std::string::npos) << error.cause;
    EXPECT_NE(error.remedy.find("unset VK_ICD_FILENAMES"), std::string::npos) << error.remedy;
    EXPECT_NE(errorWithDriver("").remedy.find("unset VK_ICD_FILENAMES"), std::string::npos) << "the loader takes an empty one for a limit";
    // What is there already need not be installed.
    const bool seen = error.cause.find("driver manifests seen:") != std::string::npos;
    EXPECT_EQ(error.remedy.find("one of the manifests seen") != std::string::npos, seen) << error.cause << "\n" << error.remedy;
    EXPECT_EQ(error.remedy.find("mesa-vulkan-drivers") == std::string::npos, seen) << error.cause << "\n" << error.remedy;
    // The usual folders may have a manifest of NVIDIA's as well.
    EXPECT_EQ(error.remedy.find("libegl1") != std::string::npos, error.cause.find("nvidia") != std::string::npos) << error.remedy;
    EXPECT_NE(errorWithDriver("/nonexistent/nvidia_icd.json").remedy.find("libegl1"), std::string::npos);
}

// A driver that answers every question and computes nothing lacks nearly all that is asked for.
TEST(Device, NamesWhatADeviceLacks) {
    if (!*CMPG_MOCK_DRIVER)
        GTEST_SKIP() << "there is no driver that lacks something: the package chromium-common has one, libVkICD_mock_icd.so";
    const test::TempFolder folder;
    const std::filesystem::path manifest = folder / "driver.json";
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
    {
        const Environment threads("LP_NUM_THREADS", "1");
        EXPECT_EQ(Device({}).driverThreads(), 1u);
    }
    constexpr int kMostOfMesa = 32; // LP_MAX_THREADS
    const Environment threads("LP_NUM_THREADS", nullptr);
    EXPECT_EQ(int(Device({}).driverThreads()), std::min(test::processorsAllowed(), kMostOfMesa));
}

// None where the layers are not there. Any other refusal is a failure, but for one that says what the layers need themselves.
std::unique_ptr<Device> validated(const Device::Options& options) {
    try {
        return std::make_unique<Device>(options);
    } catch (const Error& error) {
        const std::string what = error.what();
        const bool needs = what == "Vulkan validation failed" && error.cause.find("GPU-Assisted") != std::string::npos &&
                           error.cause.find("feature is not available") != std::string::npos;
        EXPECT_TRUE(needs || what.find("are not installed") != std::string::npos) << what << "\n" << error.cause;
        return nullptr;
    }
}

TEST(Device, ValidationFindsAMissingBarrier) {
    const std::unique_ptr<Device> device = validated({.select = {}, .validation = true, .portable = false});
    if (!device)
        GTEST_SKIP() << "the validation layers are not installed";
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
    const std::unique_ptr<Device> device = validated({});
    if (!device)
        GTEST_SKIP() << "the validation layers are not installed, or the device lacks what they need to look into kernels";
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
