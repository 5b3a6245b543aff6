// SPDX-License-Identifier: Apache-2.0
// What `--device` means: a factory of synthesizers, or the list of what there is.
#pragma once

#include <string>

#include "base/result.h"
#include "server/device/device_choice.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/options.h"

namespace seaway::server {

/// Makes the device that the options name (server/device/device_choice.h), anew at each call: the one that was made first, wherever
/// it is listed by then, and no other. "auto" chooses each time, and takes the native one as make_best() does.
SynthesizerFactory device_factory(const Options& options, ListDevices list = gpu::list_devices);

/// Where the choice is the server's own: what is chosen, or the native device, where that cannot do this sea (it computes
/// wrongly or has no kernels of a size), or cannot be made at all and `making` allows another. `had_gpu`: there was one, so that
/// one that is not there now is away. The log says what is taken, and why.
Result<std::unique_ptr<Synthesizer>> make_best(DeviceChoice choice, bool validation,
                                               const sea::RealizationPtr& sea, std::uint32_t epoch,
                                               Making making, bool& had_gpu);

/// One line a device, as `--device list` prints it; an error if there is none.
Result<std::string> device_list();

} // namespace seaway::server
