// SPDX-License-Identifier: Apache-2.0
// A device with validation layers on; one message of theirs fails the test.
#pragma once

#include <gtest/gtest.h>

#include "gpu/device.h"

namespace seaway::gpu {

class DeviceTest : public testing::Test {
  protected:
    void SetUp() override {
        Result<std::unique_ptr<Device>> made = Device::create({.validation = true});
        ASSERT_TRUE(made) << made.error().message;
        device_ = std::move(*made);
    }
    void TearDown() override {
        if (!device_)
            return;
        EXPECT_EQ(device_->validation().validation_message_count(), 0u);
        for (const std::string& message : device_->validation().validation_messages())
            ADD_FAILURE() << message;
    }

    std::unique_ptr<Device> device_;
};

} // namespace seaway::gpu
