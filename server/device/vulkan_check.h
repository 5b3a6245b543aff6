// SPDX-License-Identifier: Apache-2.0
// Self-check of a device: one small sea transformed there and summed here, every linear field and
// the Jacobian. It is also the warm-up: drivers compile kernels at their first dispatch.
#pragma once

#include "base/result.h"
#include "gpu/device.h"
#include "server/device/vulkan_kernels.h"

namespace seaway::server {

/// Error::code of a device that ran, with wrong results; other errors are of the device itself.
inline constexpr int computes_wrongly = 1;

/// The error names kernel size, field, point, both values: a device that computes wrongly is
/// refused. Cost: the drivers' compilation, then a few milliseconds.
Result<void> check_device(gpu::Device& device, const SynthesisKernels& kernels);

} // namespace seaway::server
