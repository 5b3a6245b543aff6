// SPDX-License-Identifier: Apache-2.0
// The device that a benchmark was asked for by name.
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "server/device/synthesizer.h"

namespace seaway::bench {

/// "native", or what a Vulkan device is chosen by: auto, an index or part of its name.
Result<std::unique_ptr<server::Synthesizer>> make_device(const std::string& name);

} // namespace seaway::bench
