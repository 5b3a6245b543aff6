// SPDX-License-Identifier: Apache-2.0
// KernelShelf: the kernels of each size that a device has needed, made, checked and warmed up once. For one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "base/result.h"
#include "gpu/device.h"
#include "server/device/vulkan_kernels.h"

namespace seaway::server {

class KernelShelf {
  public:
    /// `any_device`: design W even where a faster one fits. The device must outlive it.
    KernelShelf(gpu::Device& device, bool any_device) : device_(device), any_device_(any_device) {}

    /// The first design of the size that fits the device and computes rightly there; some seconds where a driver has to
    /// compile it. An error of kind DeviceError::cannot_do_this_sea names the sizes that there are, or what is wrong.
    Result<const SynthesisKernels*> get(int size, bool band_limited);

    /// " T16:256 W:512 (all modes)", and what was refused.
    std::string description() const;

  private:
    gpu::Device& device_;
    bool any_device_;
    std::map<std::pair<int, bool>, std::unique_ptr<SynthesisKernels>> kernels_; ///< size, band
    std::string refused_; ///< designs that the self-check found wrong
};

} // namespace seaway::server
