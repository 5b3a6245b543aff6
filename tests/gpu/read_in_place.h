// SPDX-License-Identifier: Apache-2.0
// Whether a processor reads the memory of the device that tests run on where it stands. A processor as device has no other
// memory, so that what hangs on it is never left out there; a GPU with memory of its own lacks the part that is tested.
#pragma once

#include <gtest/gtest.h>

#include "gpu/device.h"

namespace seaway::gpu {

inline bool reads_in_place(const Device& device) {
    EXPECT_TRUE(device.unified_memory() || !device.info().is_cpu()) << device.info().name;
    return device.unified_memory();
}

inline bool reads_in_place() {
    static const bool reads = reads_in_place(*Device::create({}).value());
    return reads;
}

inline constexpr const char* not_in_place = "a processor does not read this GPU's memory in place";

} // namespace seaway::gpu
