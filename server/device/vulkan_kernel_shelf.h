// SPDX-License-Identifier: Apache-2.0
// KernelShelf: the kernels of each size that a device has needed, made, checked and warmed up once; which design, is said by
// a file of choices, or measured, or by the order in which designs are listed. For one thread.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "gpu/device.h"
#include "server/device/kernel_choices.h"
#include "server/device/vulkan_kernels.h"
#include "server/device/vulkan_tuning.h"

namespace seaway::server {

class KernelShelf {
  public:
    /// `any_device`: design W even where a faster one fits. The device must outlive it.
    KernelShelf(gpu::Device& device, bool any_device, KernelTuning tuning)
        : device_(device), any_device_(any_device), tuning_(std::move(tuning)) {}

    /// A design of the size that fits the device and computes rightly there; some seconds where a driver has to compile it,
    /// and a few times that where designs are measured. An error of kind DeviceError::cannot_do_this_sea names the sizes
    /// that there are, or what is wrong. A design that is to be tried, or was remembered, and fails on this device is noted
    /// and passed over; any other error is of the design that is used where nothing is known, or of a device that is lost.
    Result<const SynthesisKernels*> get(int size, bool band_limited);

    /// " T16:512 W:1024 (all modes)", what was refused or failed, and why choices could not be read or kept.
    std::string description() const;

  private:
    using Designs = std::vector<const shaders::Transform*>;
    using Made = std::unique_ptr<SynthesisKernels>;

    Designs fitting(int size, bool band_limited, bool to_be_tried) const;
    /// What is remembered of these, first; nothing: as they are.
    const shaders::Transform* remembered(const KernelChoice& asked, const Designs& designs);
    /// Null: it computes wrongly, which is noted.
    Result<Made> made_and_checked(const shaders::Transform& design);
    /// The same of one that a start can do without: null also where the device fails to make or run it, which is noted,
    /// unless it is lost.
    Result<Made> tried(const shaders::Transform& design);
    /// The fastest, which is remembered. Null: none could be made, computes rightly or could be timed.
    Result<Made> fastest(const KernelChoice& asked, const Designs& designs);
    Result<Made> first(const Designs& designs);
    Result<Made> chosen(int size, bool band_limited);
    void note(const std::string& text);

    gpu::Device& device_;
    bool any_device_;
    KernelTuning tuning_;
    std::map<std::pair<int, bool>, Made> kernels_; ///< size, band
    std::string
        notes_; ///< designs that the self-check found wrong or that failed; the file of choices
    Error wrong_{""}; ///< of the last of those
};

} // namespace seaway::server
