// SPDX-License-Identifier: Apache-2.0
// seaway-view --bench: what a frame costs, pass by pass.
#pragma once

#include "base/result.h"
#include "client/view/renderer.h"
#include "client/view/sea/sea_source.h"
#include "client/view/view_options.h"

namespace seaway::client {

/// Draws options.bench_frames frames, options.rate apart, from options.camera, and prints medians of the passes by
/// the device's clock, frames a second by the wall's, and CPU time of the whole process a frame, on stdout. Until a frame of
/// the sea is there no clock counts. Errors: Failure::bad_argument where the sea has not what options ask for; see exit_code().
Result<void> bench(SeaSource& source, Renderer& renderer, const ViewOptions& options);

} // namespace seaway::client
