// SPDX-License-Identifier: Apache-2.0
// What water looks like, by name: Jerlov's ten optical types (Marine Optics, 1976), from the clearest ocean (I) to
// turbid coasts (9C). The numbers are frozen: they travel (protocol/seaway.fbs). What each does to light:
// client/view/water_optics.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

namespace seaway::sea {

/// `north_sea`, the default, is a colour that was chosen by eye, with the attenuation of III.
enum class WaterType : std::uint8_t {
    north_sea = 0,
    jerlov_1 = 1,
    jerlov_1a = 2,
    jerlov_1b = 3,
    jerlov_2 = 4,
    jerlov_3 = 5,
    coastal_1 = 6,
    coastal_3 = 7,
    coastal_5 = 8,
    coastal_7 = 9,
    coastal_9 = 10,
};

/// By number; the names that scenes, looks and options have.
inline constexpr std::array<std::pair<std::string_view, WaterType>, 11> water_types{{
    {"north_sea", WaterType::north_sea},
    {"I", WaterType::jerlov_1},
    {"IA", WaterType::jerlov_1a},
    {"IB", WaterType::jerlov_1b},
    {"II", WaterType::jerlov_2},
    {"III", WaterType::jerlov_3},
    {"1C", WaterType::coastal_1},
    {"3C", WaterType::coastal_3},
    {"5C", WaterType::coastal_5},
    {"7C", WaterType::coastal_7},
    {"9C", WaterType::coastal_9},
}};

constexpr std::string_view name_of(WaterType type) {
    return water_types[static_cast<std::size_t>(type)].first;
}

/// The sea floor's share of light that it sends back, red, green, blue: coral sand has 0.34 at 450 nm and 0.42 at
/// 525 nm (Maritorena, Morel, Gentili 1994, figure 6); red goes on as that curve does.
inline constexpr std::array<double, 3> sand_albedo{0.48, 0.42, 0.34};

/// Water and sea floor of a scene.
struct Water {
    WaterType type = WaterType::north_sea;
    std::array<double, 3> bottom_albedo = sand_albedo; ///< each 0 .. 1
    bool operator==(const Water&) const = default;
};

} // namespace seaway::sea
