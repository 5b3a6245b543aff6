// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/scene_systems.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/check.h"
#include "sea/scene/presets.h"
#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/scene/scene_tables.h"

namespace seaway::sea {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

} // namespace

void read_direction(TomlTable& table, double& towards_rad, bool required) {
    double from_deg = 0.0;
    if (required)
        table.require("from_deg");
    if (table.number("from_deg", from_deg, any_bearing))
        towards_rad = towards_from_bearing(from_deg);
}

namespace {

/// Those of the spectra that may stand in a system of this type.
template <bool SpectrumName::*may>
void read_spectrum(TomlTable& table, SpectrumKind& kind) {
    std::vector<TomlTable::Choice<SpectrumKind>> allowed;
    for (const auto& choice : spectrum_names)
        if (spectrum_name(choice.second).*may)
            allowed.push_back(choice);
    table.choice("spectrum", kind, allowed);
}

} // namespace

SpreadingModel read_spreading(TomlTable& table, SpreadingModel model) {
    table.choice("spreading", model.kind, spreading_names);
    if (has_exponent(model.kind))
        table.number("spreading_exponent", model.exponent, {0.0, spreading_exponent_max});
    else
        table.refuse("spreading_exponent", "only for spreading = \"cos2s\" or \"cos2_cos2s\"");
    if (is_blend(model.kind))
        table.number("narrow_share", model.narrow_share, {0.0, 1.0});
    else
        table.refuse("narrow_share", "only for the blends, \"cos2_cos2s\" and \"cos2_hasselmann\"");
    table.number("swell", model.swell, {0.0, 1.0});
    table.number("isotropic", model.isotropic, {0.0, 1.0});
    return model;
}

namespace {

/// Phillips by its constant, or by a height that the constant follows from.
void read_phillips(TomlTable& table, WindSea& sea, double gravity_mps2) {
    table.flag("phillips_upwind", sea.phillips_upwind);
    double height_m = 0.0;
    if (!table.has("significant_height_m")) {
        table.number("phillips_constant", sea.phillips_constant, {0.0, 1.0});
        return;
    }
    table.refuse("phillips_constant", "excludes significant_height_m: give one of the two");
    if (!table.number("significant_height_m", height_m, {0.0, 40.0}))
        return;
    sea.significant_height_m = height_m;
    const double length = sea.wind_speed_10m_mps * sea.wind_speed_10m_mps / gravity_mps2;
    const double unit_variance = pi * length * length * (sea.phillips_upwind ? 0.5 : 0.25);
    sea.phillips_constant = height_m * height_m / 16.0 / unit_variance;
    if (height_m == 0.0)
        sea.phillips_constant = 0.0;
    if (!(sea.phillips_constant <= 1.0))
        table.bad_value("significant_height_m", fmt::format("{}", height_m),
                        fmt::format("0 .. {:.3g} at this wind (a Phillips constant of 1)",
                                    4.0 * std::sqrt(unit_variance)));
}

void read_wind(TomlTable& table, WindSea& sea) {
    constexpr Range winds{0.0, 100.0};
    constexpr std::string_view other = "wind_speed_19m5_mps";
    if (!table.has(other)) {
        table.require("wind_speed_10m_mps");
        table.number("wind_speed_10m_mps", sea.wind_speed_10m_mps, winds);
    } else if (sea.spectrum != SpectrumKind::pierson_moskowitz) {
        table.refuse(other, "only for spectrum = \"pierson_moskowitz\"; the others take "
                            "wind_speed_10m_mps");
    } else if (table.has("wind_speed_10m_mps")) {
        table.refuse(other, "excludes wind_speed_10m_mps: give one of the two");
    } else {
        double speed_mps = 0.0;
        if (table.number(other, speed_mps, winds))
            sea.wind_speed_19m5_mps = speed_mps;
        sea.wind_speed_10m_mps = speed_mps / wind_19m5_over_10m;
    }
}

WindSea read_wind_sea(TomlTable& table, double gravity_mps2) {
    WindSea sea;
    read_spectrum<&SpectrumName::of_wind>(table, sea.spectrum);
    read_wind(table, sea);
    read_direction(table, sea.towards_rad);
    if (sea.spectrum == SpectrumKind::jonswap || sea.spectrum == SpectrumKind::tma) {
        table.number("fetch_m", sea.fetch_m, {0.0, endless});
        table.number("gamma", sea.gamma, {1.0, 20.0});
    } else {
        table.refuse("fetch_m", "only for spectrum = \"jonswap\" or \"tma\"");
        table.refuse("gamma", "only for spectrum = \"jonswap\" or \"tma\"");
    }
    if (sea.spectrum == SpectrumKind::phillips)
        read_phillips(table, sea, gravity_mps2);
    else
        for (const char* key : {"phillips_constant", "phillips_upwind", "significant_height_m"})
            table.refuse(key,
                         "unknown key here: of a wind sea only spectrum = \"phillips\" has it");
    SpreadingModel usual;
    usual.kind =
        sea.spectrum == SpectrumKind::phillips ? SpreadingKind::cos2 : SpreadingKind::hasselmann;
    sea.spreading = read_spreading(table, usual);
    return sea;
}

Swell read_swell(TomlTable& table) {
    Swell swell;
    read_spectrum<&SpectrumName::of_swell>(table, swell.spectrum);
    table.require("significant_height_m");
    table.number("significant_height_m", swell.significant_height_m, {0.0, 40.0});
    table.require("peak_period_s");
    table.number("peak_period_s", swell.peak_period_s, {0.05, 100.0});
    read_direction(table, swell.towards_rad);
    if (swell.spectrum != SpectrumKind::bretschneider)
        table.number("gamma", swell.gamma, {1.0, 20.0});
    else
        table.refuse("gamma",
                     "only for spectrum = \"jonswap\" or \"tma\"; bretschneider has gamma 1");
    swell.spreading = read_spreading(table, {});
    return swell;
}

void read_system(TomlTable& table, const std::string& base_dir, SeaState& sea) {
    if (table.has("preset")) {
        read_preset(table, sea, true);
        return;
    }
    std::vector<TomlTable::Choice<std::size_t>> types;
    for (const std::string_view name : system_names)
        types.emplace_back(name, types.size());
    std::size_t type = 0;
    table.require("type");
    if (!table.choice("type", type, types))
        return;
    const auto add = [&](WaveSystem system) {
        SEAWAY_CHECK(system.index() == type, "a type of wave system is read as another");
        sea.systems.push_back(std::move(system));
    };
    switch (type) {
    case 0:
        return add(read_wind_sea(table, sea.gravity_mps2));
    case 1:
        return add(read_swell(table));
    case 2:
        return add(read_measured(table, base_dir));
    case 3:
        return add(read_modes(table, base_dir));
    default:
        return add(read_sines(table, base_dir, sea));
    }
}

} // namespace

void read_preset(TomlTable& table, SeaState& sea, bool needs_direction) {
    std::string name;
    if (!table.text("preset", name))
        return;
    std::optional<Swell> swell = preset_sea(name);
    if (!swell) {
        table.bad_value("preset", '"' + name + '"', std::string(preset_names));
        return;
    }
    read_direction(table, swell->towards_rad, needs_direction);
    sea.systems.emplace_back(*swell);
}

void read_systems(TomlTable& sea_table, const std::string& base_dir, SeaState& sea) {
    const std::vector<TomlTable> tables = sea_table.tables("system", scene_systems_max);
    const std::size_t most = scene_systems_max - sea.systems.size();
    if (tables.size() > most)
        return sea_table.bad_value("system", fmt::format("{} of them", tables.size()),
                                   fmt::format("at most {} beside a preset", most));
    for (TomlTable table : tables) {
        read_system(table, base_dir, sea);
        table.finish();
    }
}

} // namespace seaway::sea
