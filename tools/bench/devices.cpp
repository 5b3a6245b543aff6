// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/devices.h"

#include "server/device/native_synthesizer.h"
#include "server/device/vulkan_synthesizer.h"

namespace seaway::bench {

using server::Synthesizer;

Result<std::unique_ptr<Synthesizer>> make_device(const std::string& name) {
    if (name == "native")
        return std::unique_ptr<Synthesizer>(std::make_unique<server::NativeSynthesizer>());
    Result<std::unique_ptr<server::VulkanSynthesizer>> made =
        server::make_vulkan_synthesizer({name, false});
    if (!made)
        return made.error();
    return std::unique_ptr<Synthesizer>(std::move(made).value());
}

} // namespace seaway::bench
