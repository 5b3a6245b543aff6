// SPDX-License-Identifier: Apache-2.0
// The keys of look files, in one table: reader, writer, `--list-look` and the test of docs/view.md go through it.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "base/toml_document.h"
#include "client/view/sky/look.h"

namespace seaway::client {

/// A number of a Look.
struct LookNumber {
    Range range;
    double& (*of)(Look&);
    double unit = 1; ///< what 1 of the file is in the Look
};
/// Three numbers.
struct LookTriple {
    Range range;
    glm::dvec3& (*of)(Look&);
};
/// What is read and written by hand (look_file.cpp).
enum class LookWord { hour, latitude, longitude, utc, exposure, environment, water, bottom };

struct LookKey {
    std::string_view table, key;
    std::variant<LookNumber, LookTriple, LookWord> value;
    std::string_view meaning;
};

std::span<const LookKey> look_keys();
/// "200 .. 280", "[red, green, blue], each 0 .. 1", ...
std::string allowed(const LookKey& key);

inline constexpr Range hours{0, 24};
inline constexpr Range latitudes_deg{-90, 90};
inline constexpr Range longitudes_deg{-180, 180};
inline constexpr Range cloud_shares{0, 1};
inline constexpr Range albedos{0, 1};
/// Starlight to the sun's disc.
inline constexpr Range exposure_values{-16, 32};
inline constexpr Range exposure_factors{1e-9, 1e9};
inline constexpr Range exposure_stops{-4, 4};
inline constexpr Range visibilities_km{visibility_min_m / 1000, visibility_max_m / 1000};

} // namespace seaway::client
