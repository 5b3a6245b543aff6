// SPDX-License-Identifier: Apache-2.0
// Words and bearings of scene files: shared by the reader and the writer.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <variant>

#include "base/toml_document.h"
#include "sea/basics/constants.h"
#include "sea/scene/accuracy_presets.h"
#include "sea/spectrum/spreading.h"
#include "sea/waves/sea_state.h"
#include "sea/waves/statistics/moments.h"

namespace seaway::sea {

/// The words of scenes stand once, one case a kind: a kind without a case does not compile (-Wswitch),
/// and the tables below grow with the cases.
struct SpectrumName {
    std::string_view name;
    bool of_wind; ///< may stand in a system of type "wind"
    bool of_swell;
};

constexpr SpectrumName spectrum_name(SpectrumKind kind) {
    switch (kind) {
    case SpectrumKind::jonswap:
        return {"jonswap", true, true};
    case SpectrumKind::tma:
        return {"tma", true, true};
    case SpectrumKind::pierson_moskowitz:
        return {"pierson_moskowitz", true, false};
    case SpectrumKind::phillips:
        return {"phillips", true, false};
    case SpectrumKind::bretschneider:
        return {"bretschneider", false, true};
    }
    return {"", false, false};
}

constexpr std::string_view name_of(SpectrumKind kind) {
    return spectrum_name(kind).name;
}

constexpr std::string_view name_of(SpreadingKind kind) {
    switch (kind) {
    case SpreadingKind::cos2:
        return "cos2";
    case SpreadingKind::cos2s:
        return "cos2s";
    case SpreadingKind::mitsuyasu:
        return "mitsuyasu";
    case SpreadingKind::hasselmann:
        return "hasselmann";
    case SpreadingKind::donelan_banner:
        return "donelan_banner";
    case SpreadingKind::cos2_cos2s:
        return "cos2_cos2s";
    case SpreadingKind::cos2_hasselmann:
        return "cos2_hasselmann";
    }
    return "";
}

constexpr std::string_view name_of(SineKind kind) {
    switch (kind) {
    case SineKind::sine:
        return "sine";
    case SineKind::gerstner:
        return "gerstner";
    case SineKind::exponential:
        return "exponential";
    case SineKind::noise:
        return "noise";
    }
    return "";
}

constexpr std::string_view name_of(CoefficientFrame frame) {
    switch (frame) {
    case CoefficientFrame::from_clockwise_north:
        return "from_clockwise_north";
    case CoefficientFrame::towards_anticlockwise_east:
        return "towards_anticlockwise_east";
    }
    return "";
}

/// Every kind that has a name, in the order of the enum, which counts from 0.
template <class E>
constexpr auto named_kinds() {
    constexpr std::size_t count = [] {
        std::size_t n = 0;
        while (!name_of(static_cast<E>(n)).empty())
            ++n;
        return n;
    }();
    std::array<std::pair<std::string_view, E>, count> kinds{};
    for (std::size_t i = 0; i < count; ++i)
        kinds[i] = {name_of(static_cast<E>(i)), static_cast<E>(i)};
    return kinds;
}

inline constexpr auto spectrum_names = named_kinds<SpectrumKind>();
inline constexpr auto spreading_names = named_kinds<SpreadingKind>();
inline constexpr auto sine_names = named_kinds<SineKind>();
inline constexpr auto frame_names = named_kinds<CoefficientFrame>();
inline constexpr auto accuracy_preset_names = named_kinds<AccuracyPreset>();

/// The word of `type` of each kind of system, in the order of the variant.
inline constexpr std::array<std::string_view, std::variant_size_v<WaveSystem>> system_names{
    "wind", "swell", "measured", "modes", "sines"};
static_assert(!system_names.back().empty(), "a kind of wave system without a word");

constexpr bool is_blend(SpreadingKind kind) {
    return kind == SpreadingKind::cos2_cos2s || kind == SpreadingKind::cos2_hasselmann;
}
/// Does `spreading_exponent` belong to this kind?
constexpr bool has_exponent(SpreadingKind kind) {
    return kind == SpreadingKind::cos2s || kind == SpreadingKind::cos2_cos2s;
}

inline constexpr Range any_bearing{-360.0, 360.0};

/// Where waves from this bearing (degrees, clockwise from north) go: rad anticlockwise from east,
/// in (-pi, pi].
inline double towards_from_bearing(double from_deg) {
    const double towards_deg = std::remainder(270.0 - from_deg, 360.0);
    return (towards_deg <= -180.0 ? 180.0 : towards_deg) * (pi / 180.0);
}

/// The bearing in [0, 360) that reads back as exactly this direction.
double bearing_from_towards(double towards_rad);
/// Where a sea comes from in the mean. A flat one comes from nowhere: 0, as its other numbers.
double mean_from_deg(const SeaStatistics& sea);

/// The degrees that read back as exactly this angle.
double degrees_of(double angle_rad);

} // namespace seaway::sea
