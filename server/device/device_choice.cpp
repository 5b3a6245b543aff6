// SPDX-License-Identifier: Apache-2.0
#include "server/device/device_choice.h"

#include "server/device/native_synthesizer.h"
#include "server/device/vulkan_synthesizer.h"

namespace seaway::server {

Result<DeviceChoice> choose_device(std::span<const gpu::DeviceInfo> devices,
                                   std::string_view wish) {
    if (wish == native_device)
        return DeviceChoice{{}, "asked for"};
    const Result<int> picked = gpu::pick_device(devices, wish);
    if (wish == auto_device) {
        const bool hardware = picked && !devices[static_cast<std::size_t>(*picked)].is_cpu();
        return hardware ? DeviceChoice{*picked, "the best GPU"}
                        : DeviceChoice{{}, "there is no usable GPU"};
    }
    if (!picked)
        return picked.error();
    return DeviceChoice{*picked, "asked for"};
}

Result<DeviceChoice> choose_device(std::string_view wish) {
    if (wish == native_device)
        return choose_device({}, wish);
    const Result<std::vector<gpu::DeviceInfo>> devices = gpu::list_devices();
    if (!devices && wish != auto_device)
        return devices.error();
    return choose_device(devices ? *devices : std::vector<gpu::DeviceInfo>{}, wish);
}

Result<std::unique_ptr<Synthesizer>> make_synthesizer(const DeviceChoice& choice, bool validation) {
    if (!choice.vulkan)
        return std::unique_ptr<Synthesizer>(std::make_unique<NativeSynthesizer>());
    SEAWAY_TRY_LET(std::unique_ptr<VulkanSynthesizer> made,
                   make_vulkan_synthesizer({.device = std::to_string(*choice.vulkan),
                                            .validation = validation,
                                            .tuning = usual_tuning()}));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

Result<std::unique_ptr<Synthesizer>> make_synthesizer(std::string_view wish) {
    SEAWAY_TRY_LET(const DeviceChoice choice, choose_device(wish));
    return make_synthesizer(choice);
}

} // namespace seaway::server
