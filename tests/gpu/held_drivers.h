// SPDX-License-Identifier: Apache-2.0
// Drivers stay loaded for as long as a program runs whose tests make many devices; and what is asked of such a device once.
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "gpu/device.h"
#include "gpu/instance.h"

namespace seaway::gpu {

/// Drivers and the validation layer are loaded as long as anybody has an instance: to load them anew for each device takes a
/// third of the time of tests that make hundreds. Let go of before the program ends, as each device's own instance is.
class HeldDrivers : public testing::Environment {
  public:
    void SetUp() override {
        Result<std::unique_ptr<Instance>> made = Instance::create(true, {});
        ASSERT_TRUE(made) << made.error().message;
        instance_ = std::move(*made);
    }
    void TearDown() override { instance_.reset(); }

  private:
    std::unique_ptr<Instance> instance_;
};

/// One in each program that has this header in any of its files.
inline testing::Environment* const held_drivers =
    testing::AddGlobalTestEnvironment(new HeldDrivers);

/// Of the device that tests run on.
inline const DeviceInfo& tested_device_info() {
    static const DeviceInfo info = Device::create({}).value()->info();
    return info;
}

} // namespace seaway::gpu
