// SPDX-License-Identifier: Apache-2.0
// Which design of kernels is fastest on a device: found by running them. See kernel_choices.h for what is remembered of it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "gpu/device.h"
#include "server/device/vulkan_kernels.h"

namespace seaway::server {

/// When designs are measured of which nothing is remembered.
enum class Measure {
    never,   ///< the first that fits and computes rightly
    on_gpus, ///< of CPUs as devices the order is known (docs/performance/maps.md), and each design is a second of compiling
    always
};

struct KernelTuning {
    std::string file = {}; ///< of KernelChoices; empty: nothing is remembered
    Measure measure = Measure::never;
    bool again = false; ///< whatever is remembered

    bool measures_on(const gpu::DeviceInfo& device) const {
        return measure == Measure::always || (measure == Measure::on_gpus && !device.is_cpu());
    }
};

/// What programs do: the file of this user, and hardware measured at its first start.
KernelTuning usual_tuning();

/// Seconds that a keyframe of eight fields takes with each of them, of one size: the least of some rounds, in each of which all take their
/// turn. A hundredth of a second each, more of large sizes.
Result<std::vector<double>> time_kernels(gpu::Device& device,
                                         std::span<const SynthesisKernels* const> kernels);

} // namespace seaway::server
