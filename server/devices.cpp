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

Result<std::unique_ptr<Synthesizer>> make_native(const sea::RealizationPtr& sea,
                                                 std::uint32_t epoch) {
    auto made = std::make_unique<NativeSynthesizer>();
    SEAWAY_TRY(made->set_sea(sea, epoch));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

Result<std::unique_ptr<Synthesizer>>
make_vulkan(const VulkanOptions& options, const sea::RealizationPtr& sea, std::uint32_t epoch) {
    SEAWAY_TRY_LET(std::unique_ptr<VulkanSynthesizer> made, make_vulkan_synthesizer(options));
    SEAWAY_TRY(made->set_sea(sea, epoch));
    return std::unique_ptr<Synthesizer>(std::move(made));
}

/// The best Vulkan device, or the native one where there is none or it cannot do this sea.
Result<std::unique_ptr<Synthesizer>>
make_best(const VulkanOptions& options, const sea::RealizationPtr& sea, std::uint32_t epoch) {
    Result<std::unique_ptr<VulkanSynthesizer>> made = make_vulkan_synthesizer(options);
    const Result<void> able = made ? (*made)->set_sea(sea, epoch) : Result<void>(made.error());
    if (able)
        return std::unique_ptr<Synthesizer>(*std::move(made));
    if (made && !able.error().is(DeviceError::cannot_do_this_sea))
        return able.error(); // lost or out of memory: worth another try
    spdlog::warn("device={} why=\"{}\"", native_name, able.error().message);
    return make_native(sea, epoch);
}

} // namespace

SynthesizerFactory device_factory(const Options& options) {
    if (options.device == native_name)
        return make_native;
    const auto make = options.device == "auto" ? make_best : make_vulkan;
    return [make, vulkan = VulkanOptions{options.device, options.validation}](
               const sea::RealizationPtr& sea, std::uint32_t epoch) {
        return make(vulkan, sea, epoch);
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
