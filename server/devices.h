// SPDX-License-Identifier: Apache-2.0
// What `--device` means: a factory of synthesizers, or the list of what there is.
#pragma once

#include <string>

#include "base/result.h"
#include "server/device/rebuilt_synthesizer.h"
#include "server/options.h"

namespace seaway::server {

/// Makes the device that the options name (server/device/device_choice.h), anew at each call.
/// "auto" takes the native one also where the GPU cannot do this sea: it computes wrongly or has no
/// kernels of a size.
SynthesizerFactory device_factory(const Options& options);

/// One line a device, as `--device list` prints it; an error if there is none.
Result<std::string> device_list();

} // namespace seaway::server
