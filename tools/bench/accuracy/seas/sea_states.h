// SPDX-License-Identifier: Apache-2.0
// The seas that accuracy is measured on: calm, gale and storm, each over deep and over shallow water.
// A configuration keeps a promise only if it keeps it in all six.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "base/result.h"
#include "sea/scene/scene.h"

namespace seaway::bench {

/// "calm_deep", "calm_shallow", "gale_deep", "gale_shallow", "storm_deep", "storm_shallow".
std::span<const std::string_view> sea_state_names();

/// The scene of that name, with the balanced preset's cascades and budget: those of
/// scenes/north_sea_gale.toml. Fresh seeds give fresh seas of the same spectrum.
Result<sea::Scene> sea_state(std::string_view name, std::uint64_t seed);

} // namespace seaway::bench
