// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/presets.h"

#include <array>
#include <charconv>
#include <cmath>

namespace seaway::sea {

namespace {

/// Probable wave heights of the Beaufort forces 0 .. 12, m (tests hold them against P18).
constexpr std::array<double, 13> beaufort_heights_m{0.0, 0.1, 0.2, 0.6, 1.0,  2.0, 3.0,
                                                    4.0, 5.5, 7.0, 9.0, 11.5, 14.0};

struct WmoState {
    double height_max_m;
    double
        height_middle_m; ///< of 9, which has no end, a little above its beginning, which is still 8
    std::string_view name;
};
constexpr std::array<WmoState, 10> wmo_states{{{0.0, 0.0, "calm (glassy)"},
                                               {0.1, 0.05, "calm (rippled)"},
                                               {0.5, 0.3, "smooth"},
                                               {1.25, 0.875, "slight"},
                                               {2.5, 1.875, "moderate"},
                                               {4.0, 3.25, "rough"},
                                               {6.0, 5.0, "very rough"},
                                               {9.0, 7.5, "high"},
                                               {14.0, 11.5, "very high"},
                                               {1e9, 14.1, "phenomenal"}}};

/// Bales 1983: mean height and most probable period of the rows 0-1 (which has
/// no period; a ripple's), 2 .. 8, >8.
struct BalesRow {
    double height_m;
    double period_s;
};
constexpr std::array<BalesRow, 9> north_atlantic{{{0.05, 3.0},
                                                  {0.3, 7.5},
                                                  {0.88, 7.5},
                                                  {1.88, 8.8},
                                                  {3.25, 9.7},
                                                  {5.0, 12.4},
                                                  {7.5, 15.0},
                                                  {11.5, 16.4},
                                                  {14.0, 20.0}}};

Swell developed_sea(double height_m) {
    Swell swell;
    swell.spectrum = SpectrumKind::bretschneider;
    swell.significant_height_m = height_m;
    swell.peak_period_s = height_m > 0.0 ? fully_developed_period_s(height_m) : 1.0;
    return swell;
}

/// A whole number 0 .. last, all of `text`.
std::optional<std::size_t> index_of(std::string_view text, std::size_t last) {
    std::size_t value = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || value > last)
        return std::nullopt;
    return value;
}

std::optional<double> number_of(std::string_view text, double lo, double hi) {
    double value = 0.0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !(value >= lo && value <= hi))
        return std::nullopt;
    return value;
}

} // namespace

double fully_developed_period_s(double significant_height_m) {
    // Hs = 0.20925 U^2/g and wp = 0.87716 g/U at U19.5, with U taken out.
    return two_pi / (0.877163 * std::sqrt(0.20925)) *
           std::sqrt(significant_height_m / gravity_default_mps2);
}

std::optional<Swell> preset_sea(std::string_view name) {
    const std::size_t colon = name.find(':');
    if (colon == std::string_view::npos)
        return std::nullopt;
    const std::string_view kind = name.substr(0, colon);
    const std::string_view value = name.substr(colon + 1);
    if (kind == "beaufort") {
        if (const auto force = index_of(value, beaufort_heights_m.size() - 1))
            return developed_sea(beaufort_heights_m[*force]);
    } else if (kind == "wmo") {
        if (const auto code = index_of(value, wmo_states.size() - 1))
            return developed_sea(wmo_states[*code].height_middle_m);
    } else if (kind == "north_atlantic") {
        if (const auto state = index_of(value, 9); state && *state > 0) {
            Swell swell = developed_sea(0.0);
            const BalesRow& row = north_atlantic[*state - 1];
            swell.significant_height_m = row.height_m;
            swell.peak_period_s = row.period_s;
            return swell;
        }
    } else if (kind == "hs_tp") {
        const std::size_t comma = value.find(',');
        if (comma == std::string_view::npos)
            return std::nullopt;
        const auto height = number_of(value.substr(0, comma), 0.0, 40.0);
        const auto period = number_of(value.substr(comma + 1), 0.05, 100.0);
        if (height && period) {
            Swell swell = developed_sea(0.0);
            swell.significant_height_m = *height;
            swell.peak_period_s = *period;
            return swell;
        }
    }
    return std::nullopt;
}

SeaStateLabel wmo_sea_state(double significant_height_m) {
    int code = 0;
    while (code < 9 &&
           significant_height_m > wmo_states[static_cast<std::size_t>(code)].height_max_m)
        ++code;
    return {code, wmo_states[static_cast<std::size_t>(code)].name};
}

} // namespace seaway::sea
