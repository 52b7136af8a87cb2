// The self-test of a device that is opened.
#include "base/error.h"
#include "devices.h"
#include "support/environment.h"
#include "vk/self_test.h"

#include <gtest/gtest.h>


namespace cmpg {
namespace {

// Opening the device has run it; it leaves nothing behind, whether it runs again or not.
TEST(SelfTest, PassesAndLeavesNoTrace) {
    for (Device* device : {&test::device(), &test::portableDevice()}) {
        Device own({.select = {}, .validation = false, .portable = device->portable()});
        EXPECT_NO_THROW(selfTest(own));
        EXPECT_EQ(own.memory().peak, 0u);
        EXPECT_TRUE(own.memory().buffers.empty());
        EXPECT_TRUE(own.kernelTimes().empty());
    }
}

TEST(SelfTest, AWrongResultIsRefused) {
    const DeviceInfo device = test::device().info(); // opened before anything is wrong
    for (const bool portable : {false, true}) {
        try {
            const test::Environment wrong("CMPG_FAULT", "wrong");
            Device({.select = {}, .validation = false, .portable = portable});
            FAIL() << "a device with a wrong result was opened";
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Device);
            EXPECT_NE(std::string(error.what()).find(device.name), std::string::npos) << error.what();
            EXPECT_NE(error.cause.find(device.driver), std::string::npos) << error.cause;
            EXPECT_NE(error.cause.find("reads in a loop (292, not 293)"), std::string::npos) << error.cause; // and nothing else
            EXPECT_EQ(error.cause.find("sums"), std::string::npos) << error.cause;
        }
        EXPECT_NO_THROW(Device({.select = {}, .validation = false, .portable = portable}));
    }
}

} // namespace
} // namespace cmpg
