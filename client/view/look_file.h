// SPDX-License-Identifier: Apache-2.0
// Look files: a Look as TOML, read as strictly as a scene is. What a file leaves out stays at its default. Keys and
// ranges: look_keys.h, docs/view.md.
//
//     Result<Look> look = read_look("looks/dawn.toml");
//     if (!look) ...   // "looks/dawn.toml:4: air.visibility_km: 0.1 is not allowed; allowed: a number 0.2 .. 280"
//
// Pure functions, but for the files; thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "base/result.h"
#include "client/view/sea/sea_frame.h"
#include "client/view/sky/look.h"

namespace seaway::client {

inline constexpr std::size_t look_text_bytes_max = 1u << 16;

Result<Look> read_look(const std::string& path);
/// `name` is quoted in errors; files that the text names are relative to `base_dir`.
Result<Look> parse_look(std::string_view text, const std::string& name,
                        const std::string& base_dir);

/// The look with what does not count at its default: an hour beside a place; clouds, hour and place beside a picture of the
/// sky; the turn of no picture.
Look in_force(Look look);

/// Every value that counts; reads back as in_force(look).
std::string to_toml(const Look& look);
/// Refuses the name of a sky that could not be read. Only a regular file is replaced; the file is either the old or the new one, whole.
Result<void> write_look(const Look& look, const std::string& path);

/// "auto", "14.5ev" or a factor; the error says what is allowed, without where.
Result<Exposure> parse_exposure(std::string_view text);
std::string to_text(const Exposure& exposure);
/// The factor to a picture in kcd/m2, if it is set: by EV, 18 % grey is what a meter of K = 12.5 cd/m2 (ISO 2720) looks
/// at; 15 is full sun.
std::optional<double> fixed_exposure(const Exposure& exposure);

/// What is set or else `metered`, and the look's stops.
double exposure_of(const Look& look, double metered);

/// What the look says of the water, over what the sea says of itself.
void set_water(SeaFrame& frame, const Look& look);

} // namespace seaway::client
