// SPDX-License-Identifier: Apache-2.0
// Seas by what people say: a Beaufort number, a WMO sea state, a row of the North Atlantic table, a
// height and a period. Climatology, not measurement: the middle of what the words cover.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sea/waves/sea_state.h"

namespace seaway::sea {

/// "beaufort:0" .. "beaufort:12"   probable height of open-sea waves (WMO), fully developed
/// "wmo:0" .. "wmo:9"              middle height of the sea state (code table 3700), fully
/// developed "north_atlantic:1" .. ":9"      mean height, most probable period (Bales 1983; 1 is
/// its "0-1", 9
///                                 its "above 8"), Bretschneider
/// "hs_tp:3.5,9"                   Bretschneider of this Hs (m, 0 .. 40) and Tp (s, 0.05 .. 100)
/// A fully developed sea of a height has Tp = 5.00 sqrt(Hs): Pierson-Moskowitz without its wind.
/// Spread as cos2s with s = 10, Goda and Suzuki's value for wind seas. Absent if unknown.
std::optional<Swell> preset_sea(std::string_view name);

/// What a preset may be, for error messages.
inline constexpr std::string_view preset_names =
    "beaufort:0 .. 12 | wmo:0 .. 9 | north_atlantic:1 .. 9 | hs_tp:HS_M,TP_S";

/// Code and words of WMO table 3700 for a height; a height on a boundary has the lower code.
struct SeaStateLabel {
    int code;
    std::string_view name;
};
SeaStateLabel wmo_sea_state(double significant_height_m);

/// Peak period of a fully developed sea of this height, s (Pierson-Moskowitz).
double fully_developed_period_s(double significant_height_m);

} // namespace seaway::sea
