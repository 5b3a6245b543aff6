// SPDX-License-Identifier: Apache-2.0
#include "server/device/device_choice.h"

#include "gpu/device.h"
#include "server/device/native_synthesizer.h"
#include "server/device/vulkan_synthesizer.h"

namespace seaway::server {

namespace {

DeviceChoice chosen(std::span<const gpu::DeviceInfo> devices, int index, const char* why) {
    return {index, why, devices[static_cast<std::size_t>(index)].identity()};
}

} // namespace

Result<DeviceChoice> choose_device(std::span<const gpu::DeviceInfo> devices,
                                   std::string_view wish) {
    if (wish == native_device)
        return DeviceChoice{{}, "asked for"};
    const Result<int> picked = gpu::pick_device(devices, wish);
    if (wish == auto_device) {
        const bool hardware = picked && !devices[static_cast<std::size_t>(*picked)].is_cpu();
        return hardware ? chosen(devices, *picked, "the best GPU")
                        : DeviceChoice{{}, "there is no usable GPU"};
    }
    if (!picked)
        return picked.error();
    return chosen(devices, *picked, "asked for");
}

Result<DeviceChoice> choose_device(std::string_view wish, const ListDevices& list) {
    if (wish == native_device)
        return choose_device({}, wish);
    const Result<std::vector<gpu::DeviceInfo>> devices = list();
    if (!devices && wish != auto_device)
        return devices.error();
    return choose_device(devices ? *devices : std::vector<gpu::DeviceInfo>{}, wish);
}

Result<DeviceChoice> choose_again(const DeviceChoice& before, const ListDevices& list) {
    if (!before.device)
        return before;
    SEAWAY_TRY_LET(const std::vector<gpu::DeviceInfo> devices, list());
    SEAWAY_TRY_LET(const int index, gpu::find_device(devices, *before.device, *before.vulkan));
    return DeviceChoice{index, before.why, before.device};
}

Result<std::unique_ptr<Synthesizer>> make_synthesizer(const DeviceChoice& choice, bool validation) {
    if (!choice.vulkan)
        return std::unique_ptr<Synthesizer>(std::make_unique<NativeSynthesizer>());
    SEAWAY_TRY_LET(std::shared_ptr<gpu::Device> device,
                   gpu::Device::create({.pick = std::to_string(*choice.vulkan),
                                        .only = choice.device,
                                        .validation = validation}));
    SEAWAY_TRY_LET(std::unique_ptr<VulkanSynthesizer> made,
                   make_vulkan_synthesizer(std::move(device), {.tuning = usual_tuning()}));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

Result<std::unique_ptr<Synthesizer>> make_synthesizer(std::string_view wish) {
    SEAWAY_TRY_LET(const DeviceChoice choice, choose_device(wish));
    return make_synthesizer(choice);
}

} // namespace seaway::server
