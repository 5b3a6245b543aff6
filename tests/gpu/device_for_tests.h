// SPDX-License-Identifier: Apache-2.0
// A device with validation layers on, one for all tests of a suite; one message of theirs fails the test.
#pragma once

#include <gtest/gtest.h>

#include "gpu/device.h"
#include "tests/gpu/held_drivers.h"

namespace seaway::gpu {

class DeviceTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        Result<std::unique_ptr<Device>> made = Device::create({.validation = true});
        ASSERT_TRUE(made) << made.error().message;
        device_ = std::move(*made);
    }
    static void TearDownTestSuite() { device_.reset(); }

    void SetUp() override {
        ASSERT_TRUE(device_);
        messages_before_ = device_->validation().validation_message_count();
    }
    void TearDown() override {
        if (device_)
            expect_no_messages(device_->validation(), messages_before_);
    }
    /// After so many that other tests have been failed for.
    static void expect_no_messages(const Instance& layers, std::size_t before = 0) {
        EXPECT_EQ(layers.validation_message_count(), before);
        const std::vector<std::string> messages = layers.validation_messages();
        for (std::size_t i = before; i < messages.size(); ++i)
            ADD_FAILURE() << messages[i];
    }

    static inline std::unique_ptr<Device> device_;

  private:
    std::size_t messages_before_ = 0;
};

} // namespace seaway::gpu
