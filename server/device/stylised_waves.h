// SPDX-License-Identifier: Apache-2.0
// Stylised waves, which no transform carries, on the way to keyframes: the same on every device.
#pragma once

#include <span>

#include "server/device/synthesizer.h"

namespace seaway::server {

/// Adds those of the sea to the keyframes of these requests, point by point, and to the counters what it took.
void add_stylised(std::span<const KeyframeRequest> requests, const sea::Realization& sea,
                  std::span<const NewKeyframePtr> made, SynthesisCounters& counters);

} // namespace seaway::server
