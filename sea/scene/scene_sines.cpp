// SPDX-License-Identifier: Apache-2.0
// Stylised waves of a scene: ramps, or a list in physical units.
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/scene/scene_tables.h"
#include "sea/waves/sine_limits.h"

namespace seaway::sea {

namespace {

constexpr int noise_octaves_max = 16;

struct Column {
    const char* name;
    Range range;
};
/// The last may be absent.
constexpr std::array<Column, 5> list_columns{{{"wavelength_m", {0.01, 1e6}},
                                              {"amplitude_m", {0.0, 100.0}},
                                              {"from_deg", any_bearing},
                                              {"phase_rad", {-1000.0, 1000.0}},
                                              {"speed_mps", {0.01, 1000.0}}}};

Result<std::vector<SineByHand>> parse_list(const std::string& csv, const std::string& name) {
    const Result<CsvTable> table = parse_csv(csv, name, sines_by_hand_max);
    if (!table)
        return table.error();
    const std::size_t count = table->columns.size();
    bool fits = count + 1 == list_columns.size() || count == list_columns.size();
    for (std::size_t c = 0; fits && c < count; ++c)
        fits = table->columns[c] == list_columns[c].name;
    if (!fits)
        return Error{name + ": the header must be wavelength_m,amplitude_m,from_deg,phase_rad, and "
                            "speed_mps behind them if waves have speeds of their own"};
    std::vector<SineByHand> waves;
    for (std::size_t r = 0; r < table->rows.size(); ++r) {
        const std::vector<double>& row = table->rows[r];
        for (std::size_t c = 0; c < count; ++c)
            if (!list_columns[c].range.contains(row[c]))
                return table->error(
                    r, fmt::format("{} = {}; allowed: {} .. {}", list_columns[c].name, row[c],
                                   list_columns[c].range.lo, list_columns[c].range.hi));
        waves.push_back({row[0], row[1], towards_from_bearing(row[2]), row[3],
                         count == list_columns.size() ? row[4] : 0.0});
    }
    return waves;
}

void read_list(TomlTable& table, const std::string& base_dir, SineRamps& ramps) {
    for (const std::string_view key : sine_ramp_keys)
        table.refuse(key, "belongs to ramps; a list of waves (file or data) stands in their place");
    const char* key = table.has("data") ? "data" : "file";
    if (ramps.kind == SineKind::noise) {
        table.refuse(key, "noise has ramps only");
        return;
    }
    std::string name;
    const std::string csv = read_data(table, base_dir, scene_text_bytes_max, name);
    if (csv.empty())
        return;
    Result<std::vector<SineByHand>> waves = parse_list(csv, name);
    if (!waves) {
        table.fail(key, waves.error().message);
        return;
    }
    ramps.by_hand = *std::move(waves);
    if (ramps.kind == SineKind::gerstner && ramps.by_hand.front().speed_mps > 0.0)
        table.fail(key, name + ": speed_mps: gerstner waves have the speed of their wavelength; "
                               "sine and exponential ones take it");
}

void read_ramps(TomlTable& table, SineRamps& ramps) {
    std::int64_t count = ramps.count;
    const bool noise = ramps.kind == SineKind::noise;
    table.integer("count", count, 1, noise ? noise_octaves_max : 64);
    ramps.count = static_cast<int>(count);
    table.number("amplitude_m", ramps.amplitude_m, {0.0, 100.0});
    table.number("wavelength_m", ramps.wavelength_m, {0.01, 1e6});
    table.number("amplitude_ratio", ramps.amplitude_ratio, {0.01, 1.0});
    table.number("wavenumber_ratio", ramps.wavenumber_ratio, {1.0, 4.0});
    read_direction(table, ramps.towards_rad);
    double step_deg = 0.0;
    double spread_deg = 0.0;
    if (table.number("direction_step_deg", step_deg, {-180.0, 180.0}))
        ramps.direction_step_rad = step_deg * (pi / 180.0);
    if (table.number("direction_spread_deg", spread_deg, {0.0, 180.0}))
        ramps.direction_spread_rad = spread_deg * (pi / 180.0);
    table.flag("normalise", ramps.normalise);
    if (ramps.kind == SineKind::gerstner)
        table.refuse("speed_ratio", "gerstner waves have the speed of their wavelength; sine, "
                                    "exponential and noise take it");
    else
        table.number("speed_ratio", ramps.speed_ratio, {0.1, 10.0});
}

/// The key and what it says, where waves are refused that follow from several keys.
struct Blamed {
    const char* key;
    std::string value;
};
Blamed blamed(const TomlTable& table, const char* ramp_key, double ramp_value) {
    if (table.has("data") || table.has("file"))
        return {table.has("data") ? "data" : "file", "a list"};
    return {ramp_key, fmt::format("{}", ramp_value)};
}

void refuse_short(TomlTable& table, const SineRamps& ramps) {
    const bool noise = ramps.kind == SineKind::noise;
    const auto [key, value] = blamed(table, "wavenumber_ratio", ramps.wavenumber_ratio);
    table.bad_value(key, value,
                    fmt::format("waves whose shortest fits the tile at most {} times{}; this one "
                                "{:.3g} times",
                                noise ? sine_steps_max / 4 : sine_steps_max,
                                noise ? " (noise)" : "", sine_steps(ramps) / (noise ? 4.0 : 1.0)));
}

bool refuse_fast(TomlTable& table, const SineRamps& ramps, const SeaState& sea) {
    const double fastest = fastest_sine_radps(
        ramps, sea.seed, static_cast<std::uint32_t>(sea.systems.size()), sea.dispersion());
    if (fastest <= rate_omega_max_radps)
        return false;
    const auto [key, value] = blamed(table, "speed_ratio", ramps.speed_ratio);
    table.bad_value(
        key, value,
        fmt::format("waves whose fastest turns at most at {:g} rad/s; this one at {:.3g} rad/s",
                    rate_omega_max_radps, fastest));
    return true;
}

void refuse_drag(TomlTable& table, const SineRamps& ramps, const SeaState& sea) {
    if (ramps.drag <= 0.0)
        return;
    const double growth =
        drag_growth(sine_field(ramps, sea.seed, static_cast<std::uint32_t>(sea.systems.size()),
                               sea.dispersion(), sea.height_scale, 0));
    if (!(growth <= drag_growth_max))
        table.bad_value(
            "drag", fmt::format("{}", ramps.drag),
            fmt::format("waves that drag those after them {:g} times as far at most, all "
                        "together; these {:.3g} times: less drag, sharpness or height",
                        drag_growth_max, growth));
}

} // namespace

SineRamps read_sines(TomlTable& table, const std::string& base_dir, const SeaState& sea) {
    SineRamps ramps;
    table.choice("shape", ramps.kind, sine_names);
    table.number("length_m", ramps.length_m, {0.1, 1e6});
    if (table.has("data") || table.has("file")) {
        read_list(table, base_dir, ramps);
    } else {
        if (ramps.kind == SineKind::noise) { // the usual octaves: half as high, half as long
            ramps.count = 4;
            ramps.amplitude_ratio = 0.5;
            ramps.wavenumber_ratio = 2.0;
        }
        read_ramps(table, ramps);
    }
    if (ramps.kind == SineKind::exponential) {
        table.number("sharpness", ramps.sharpness, {0.1, 10.0});
        table.number("drag", ramps.drag, {0.0, 2.0});
    } else {
        for (const char* key : {"sharpness", "drag"})
            table.refuse(key, "only for shape = \"exponential\"");
    }
    // Waves that are refused already are not looked at further: no number need hold them.
    if (!(sine_steps(ramps) <= sine_steps_max))
        refuse_short(table, ramps);
    else if (!refuse_fast(table, ramps, sea))
        refuse_drag(table, ramps, sea);
    return ramps;
}

} // namespace seaway::sea
