// SPDX-License-Identifier: Apache-2.0
// The part of the scene reader that knows systems with tables of data: measured seas, explicit and
// stylised waves; and what all systems share. Used by what reads and changes scenes only.
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "base/toml_document.h"
#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// From the nautical bearing `from_deg` to where waves go.
void read_direction(TomlTable& table, double& towards_rad, bool required = true);
/// The spreading keys; `model` is what stands where they are absent.
SpreadingModel read_spreading(TomlTable& table, SpreadingModel model);

MeasuredSea read_measured(TomlTable& table, const std::string& base_dir);
ExplicitModes read_modes(TomlTable& table, const std::string& base_dir);
/// `sea` as far as it is read: these waves will be its next system.
SineRamps read_sines(TomlTable& table, const std::string& base_dir, const SeaState& sea);

/// Keys of ramps, in whose place a list of waves stands. The first stands in every effective text of ramps.
inline constexpr std::array<std::string_view, 10> sine_ramp_keys{
    "count",    "amplitude_m", "wavelength_m",       "amplitude_ratio",      "wavenumber_ratio",
    "from_deg", "speed_ratio", "direction_step_deg", "direction_spread_deg", "normalise"};

/// The table of a system: the text under `data`, or the contents of `file`, which becomes `name`.
/// Empty on error.
std::string read_data(TomlTable& table, const std::string& base_dir, std::size_t bytes_max,
                      std::string& name);

} // namespace seaway::sea
