// SPDX-License-Identifier: Apache-2.0
// What `--device` means in every program that computes a sea.
//
//     native          this processor, by Seaway's own vector code
//     auto            a hardware GPU (discrete, integrated, virtual), else native: on the same cores
//                     it is about three times faster than a Vulkan driver for CPUs, which a user
//                     who wants one takes by name
//     3, "lavapipe"   a Vulkan device by index or part of its name, ignoring case
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "gpu/device_info.h"
#include "server/device/synthesizer.h"

namespace seaway::server {

inline constexpr std::string_view native_device = "native";
inline constexpr std::string_view auto_device = "auto";

struct DeviceChoice {
    std::optional<int> vulkan; ///< index in the list that was chosen from; none: native
    std::string why;           ///< for the log
    /// What stood there, and is made wherever it is listed by then; none: what stands there by then.
    std::optional<gpu::DeviceIdentity> device = {};
};

/// As gpu::list_devices().
using ListDevices = std::function<Result<std::vector<gpu::DeviceInfo>>()>;

/// Which device is meant; the error lists what there is.
Result<DeviceChoice> choose_device(std::span<const gpu::DeviceInfo> devices, std::string_view wish);

/// The same among the devices of this machine.
Result<DeviceChoice> choose_device(std::string_view wish,
                                   const ListDevices& list = gpu::list_devices);

/// The one that was chosen before, wherever it is listed now; the error lists what there is.
Result<DeviceChoice> choose_again(const DeviceChoice& before,
                                  const ListDevices& list = gpu::list_devices);

/// Makes it, without a sea. `validation`: Vulkan's validation layers. Takes up to some tenths of a
/// second on Vulkan, and more where hardware is met for the first time (KernelTuning). An error: the device cannot be used.
Result<std::unique_ptr<Synthesizer>> make_synthesizer(const DeviceChoice& choice,
                                                      bool validation = false);

/// Chooses and makes.
Result<std::unique_ptr<Synthesizer>> make_synthesizer(std::string_view wish);

} // namespace seaway::server
