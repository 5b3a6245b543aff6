// SPDX-License-Identifier: Apache-2.0
// Self-check of a device: one small sea transformed there and summed here, every linear field, the
// Jacobian, foam and, where memory is not read in place, rounding. It is also the warm-up: drivers compile kernels at their first dispatch.
#pragma once

#include "base/result.h"
#include "gpu/device.h"
#include "server/device/synthesizer.h"
#include "server/device/vulkan_kernels.h"

namespace seaway::server {

/// A device that computes wrongly is refused: DeviceError::cannot_do_this_sea, which names kernel
/// size, field, point and both values. Other errors are of the device itself. Cost: the drivers'
/// compilation, then a few milliseconds.
Result<void> check_device(gpu::Device& device, const SynthesisKernels& kernels);

} // namespace seaway::server
