// SPDX-License-Identifier: Apache-2.0
#include "server/devices.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "gpu/device_info.h"
#include "server/device/native_synthesizer.h"
#include "server/device/vulkan_synthesizer.h"

namespace seaway::server {

namespace {

constexpr std::string_view native_name = "native";

Result<std::unique_ptr<Synthesizer>> make_native() {
    return std::unique_ptr<Synthesizer>(std::make_unique<NativeSynthesizer>());
}

Result<std::unique_ptr<Synthesizer>> make_vulkan(const VulkanOptions& options) {
    Result<std::unique_ptr<VulkanSynthesizer>> made = make_vulkan_synthesizer(options);
    if (!made)
        return made.error();
    return std::unique_ptr<Synthesizer>(std::move(made).value());
}

} // namespace

SynthesizerFactory device_factory(const Options& options, sea::RealizationPtr sea) {
    if (options.device == native_name)
        return make_native;
    const VulkanOptions vulkan{options.device, options.validation};
    if (options.device != "auto")
        return [vulkan] { return make_vulkan(vulkan); };
    return [vulkan, sea = std::move(sea)]() -> Result<std::unique_ptr<Synthesizer>> {
        Result<std::unique_ptr<Synthesizer>> made = make_vulkan(vulkan);
        const Result<void> able = made ? (*made)->set_sea(sea, 0) : Result<void>(made.error());
        if (able)
            return made;
        if (made && !able.error().is(DeviceError::cannot_do_this_sea))
            return able.error(); // lost or out of memory: worth another try
        spdlog::warn("device=native why=\"{}\"", able.error().message);
        return make_native();
    };
}

Result<std::string> device_list() {
    std::string lines;
    const Result<std::vector<gpu::DeviceInfo>> devices = gpu::list_devices();
    if (devices)
        for (const gpu::DeviceInfo& device : *devices)
            lines += fmt::format("{}: {}, {}{}\n", device.index, device.name, device.driver,
                                 device.is_usable() ? "" : " - unusable: " + device.unusable);
    lines += fmt::format("{}: this processor, without Vulkan\n", native_name);
    return lines;
}

} // namespace seaway::server
