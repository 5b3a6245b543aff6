// SPDX-License-Identifier: Apache-2.0
#include "server/devices.h"

#include <optional>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/messages.h"
#include "gpu/device_info.h"

namespace seaway::server {

namespace {

Result<std::unique_ptr<Synthesizer>> make(const DeviceChoice& choice, bool validation,
                                          const sea::RealizationPtr& sea, std::uint32_t epoch) {
    SEAWAY_TRY_LET(std::unique_ptr<Synthesizer> made, make_synthesizer(choice, validation));
    SEAWAY_TRY(made->set_sea(sea, epoch));
    return made;
}

} // namespace

Result<std::unique_ptr<Synthesizer>> make_best(DeviceChoice choice, bool validation,
                                               const sea::RealizationPtr& sea, std::uint32_t epoch,
                                               Making making, bool& had_gpu) {
    if (had_gpu && !choice.vulkan && making == Making::the_same)
        return Error{"the GPU is away: " + choice.why};
    if (choice.vulkan && making == Making::another)
        choice = {{}, "the GPU fails at its work"};
    Result<std::unique_ptr<Synthesizer>> made = make(choice, validation, sea, epoch);
    // A GPU that was lost, or is out of memory, is worth another try instead, while there are any.
    if (!made && choice.vulkan &&
        (making != Making::the_same || made.error().is(DeviceError::cannot_do_this_sea))) {
        choice = {{}, made.error().message};
        made = make(choice, validation, sea, epoch);
    }
    if (made) {
        had_gpu = choice.vulkan.has_value();
        spdlog::info("device=auto takes={} why={}", in_quotes((*made)->description()),
                     in_quotes(choice.why));
    }
    return made;
}

SynthesizerFactory device_factory(const Options& options, ListDevices list) {
    return [options, list = std::move(list), had_gpu = false,
            first = std::optional<DeviceChoice>()](
               const sea::RealizationPtr& sea, std::uint32_t epoch,
               Making making) mutable -> Result<std::unique_ptr<Synthesizer>> {
        SEAWAY_TRY_LET(const DeviceChoice choice,
                       first ? choose_again(*first, list) : choose_device(options.device, list));
        if (options.device == auto_device)
            return make_best(choice, options.validation, sea, epoch, making, had_gpu);
        Result<std::unique_ptr<Synthesizer>> made = make(choice, options.validation, sea, epoch);
        if (made)
            first = choice;
        return made;
    };
}

Result<std::string> device_list() {
    std::string lines;
    const Result<std::vector<gpu::DeviceInfo>> devices = gpu::list_devices();
    if (devices)
        for (const gpu::DeviceInfo& device : *devices)
            lines += fmt::format("{}: {}, {}{}\n", device.index, device.name, device.driver,
                                 device.is_usable() ? "" : " - unusable: " + device.unusable);
    lines += fmt::format("{}: this processor, without Vulkan\n", native_device);
    return lines;
}

} // namespace seaway::server
