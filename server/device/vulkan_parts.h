// SPDX-License-Identifier: Apache-2.0
// Keyframes in parts: maps of 2048 points a side do not all stand side by side where a device binds 128 MiB at once, so
// that some are computed after the others. Pure.
#pragma once

#include <span>
#include <vector>

#include "server/device/synthesizer.h"

namespace seaway::server {

/// The same request as some of which each takes at most so many maps, at least 5; strains and what is made of them, with
/// the turn, are the first, and nothing is rounded. Itself where it fits.
std::vector<KeyframeRequest> parts_of(const KeyframeRequest& request, int maps_at_once);

/// The planes of all parts, to a keyframe that has their fields and room for their values.
void join(std::span<const NewKeyframePtr> parts, sea::Keyframe& whole);

} // namespace seaway::server
