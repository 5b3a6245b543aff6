// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/scene_systems.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "sea/scene/presets.h"
#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"

namespace seaway::sea {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr Range any_bearing{-360.0, 360.0};
constexpr std::size_t modes_max = 65536;

/// From a nautical bearing to where waves go.
void read_direction(TomlTable& table, double& towards_rad, bool required = true) {
    double from_deg = 0.0;
    if (required)
        table.require("from_deg");
    if (table.number("from_deg", from_deg, any_bearing))
        towards_rad = towards_from_bearing(from_deg);
}

SpreadingModel read_spreading(TomlTable& table, SpreadingModel model) {
    table.choice("spreading", model.kind, spreading_names);
    if (model.kind == SpreadingKind::cos2s)
        table.number("spreading_exponent", model.exponent, {0.0, spreading_exponent_max});
    table.number("swell", model.swell, {0.0, 1.0});
    table.number("isotropic", model.isotropic, {0.0, 1.0});
    return model;
}

/// Phillips by its constant, or by a height that the constant follows from.
void read_phillips(TomlTable& table, WindSea& sea, double gravity_mps2) {
    table.flag("phillips_upwind", sea.phillips_upwind);
    double height_m = 0.0;
    if (!table.has("significant_height_m")) {
        table.number("phillips_constant", sea.phillips_constant, {0.0, 1.0});
        return;
    }
    if (!table.number("significant_height_m", height_m, {0.0, 40.0}))
        return;
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

WindSea read_wind_sea(TomlTable& table, double gravity_mps2) {
    WindSea sea;
    table.choice("spectrum", sea.spectrum,
                 {{"jonswap", SpectrumKind::jonswap},
                  {"tma", SpectrumKind::tma},
                  {"pierson_moskowitz", SpectrumKind::pierson_moskowitz},
                  {"phillips", SpectrumKind::phillips}});
    constexpr Range winds{0.0, 100.0};
    if (sea.spectrum == SpectrumKind::pierson_moskowitz && table.has("wind_speed_19m5_mps")) {
        if (table.number("wind_speed_19m5_mps", sea.wind_speed_10m_mps, winds))
            sea.wind_speed_10m_mps /= wind_19m5_over_10m;
    } else {
        table.require("wind_speed_10m_mps");
        table.number("wind_speed_10m_mps", sea.wind_speed_10m_mps, winds);
    }
    read_direction(table, sea.towards_rad);
    if (sea.spectrum == SpectrumKind::jonswap || sea.spectrum == SpectrumKind::tma) {
        table.number("fetch_m", sea.fetch_m, {0.0, infinite});
        table.number("gamma", sea.gamma, {1.0, 20.0});
    }
    if (sea.spectrum == SpectrumKind::phillips)
        read_phillips(table, sea, gravity_mps2);
    SpreadingModel usual;
    usual.kind =
        sea.spectrum == SpectrumKind::phillips ? SpreadingKind::cos2 : SpreadingKind::hasselmann;
    sea.spreading = read_spreading(table, usual);
    return sea;
}

Swell read_swell(TomlTable& table) {
    Swell swell;
    table.choice("spectrum", swell.spectrum,
                 {{"bretschneider", SpectrumKind::bretschneider},
                  {"jonswap", SpectrumKind::jonswap},
                  {"tma", SpectrumKind::tma}});
    table.require("significant_height_m");
    table.number("significant_height_m", swell.significant_height_m, {0.0, 40.0});
    table.require("peak_period_s");
    table.number("peak_period_s", swell.peak_period_s, {0.05, 100.0});
    read_direction(table, swell.towards_rad);
    if (swell.spectrum != SpectrumKind::bretschneider)
        table.number("gamma", swell.gamma, {1.0, 20.0});
    swell.spreading = read_spreading(table, {});
    return swell;
}

/// Numbers and header alone: notes may hold anything, the effective scene repeats the rest.
std::string without_notes(const std::string& csv) {
    std::string kept;
    std::istringstream lines(csv);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t first = line.find_first_not_of(" \t\r");
        if (first == std::string::npos || line[first] == '#')
            continue;
        line.erase(std::remove(line.begin(), line.end(), '\r'), line.end());
        kept += line + "\n";
    }
    return kept;
}

/// The table of a system: the text under `data`, or the contents of `file`. Empty on error.
std::string read_data(TomlTable& table, const std::string& base_dir, std::string& name) {
    std::string text;
    name = "data";
    if (table.has("data")) {
        if (table.text("data", text) && text.empty())
            table.fail("data", "is empty");
        return text;
    }
    table.require("file");
    if (!table.text("file", name))
        return {};
    const std::filesystem::path path = std::filesystem::path(base_dir) / name;
    std::error_code problem;
    const auto bytes = std::filesystem::file_size(path, problem);
    std::ifstream file(path, std::ios::binary);
    if (problem || !file || bytes > scene_text_bytes_max) {
        table.bad_value("file", '"' + path.string() + '"',
                        fmt::format("a readable file of at most {} bytes", scene_text_bytes_max));
        return {};
    }
    text.assign(std::istreambuf_iterator<char>(file), {});
    if (text.empty())
        table.fail("file", path.string() + " is empty");
    return text;
}

MeasuredSea read_measured(TomlTable& table, const std::string& base_dir) {
    MeasuredSea sea;
    std::string name;
    sea.csv = read_data(table, base_dir, name);
    if (sea.csv.empty())
        return sea;
    Result<MeasuredSpectrum> spectrum = parse_measured(sea.csv, name);
    if (!spectrum) {
        table.fail(table.has("data") ? "data" : "file", spectrum.error().message);
        return sea;
    }
    if (!spectrum->has_directions()) {
        read_direction(table, sea.towards_rad);
        sea.spreading = read_spreading(table, {});
    }
    sea.csv = without_notes(sea.csv);
    sea.spectrum = std::make_shared<const MeasuredSpectrum>(*std::move(spectrum));
    return sea;
}

Result<std::vector<ExplicitMode>> parse_modes(const std::string& csv, const std::string& name) {
    const Result<CsvTable> table = parse_csv(csv, name, modes_max);
    if (!table)
        return table.error();
    if (table->columns != std::vector<std::string>{"nx", "ny", "amplitude_m", "phase_rad"})
        return Error{name + ": the header must be nx,ny,amplitude_m,phase_rad"};
    std::vector<ExplicitMode> modes;
    for (std::size_t r = 0; r < table->rows.size(); ++r) {
        const std::vector<double>& row = table->rows[r];
        const auto is_index = [](double n) { return n == std::round(n) && std::abs(n) < 1024.0; };
        if (!is_index(row[0]) || !is_index(row[1]) || (row[0] == 0.0 && row[1] == 0.0))
            return table->error(r, fmt::format("nx = {}, ny = {}; allowed: whole numbers -1023 .. "
                                               "1023, not both 0",
                                               row[0], row[1]));
        if (!(std::abs(row[2]) <= 100.0) || !(std::abs(row[3]) <= 1e3))
            return table->error(r, fmt::format("amplitude_m = {}, phase_rad = {}; allowed: -100 .. "
                                               "100, -1000 .. 1000",
                                               row[2], row[3]));
        modes.push_back({static_cast<int>(row[0]), static_cast<int>(row[1]), row[2], row[3]});
    }
    return modes;
}

ExplicitModes read_modes(TomlTable& table, const std::string& base_dir) {
    ExplicitModes system;
    table.require("length_m");
    table.number("length_m", system.length_m, {0.1, 1e6});
    std::string name;
    const std::string csv = read_data(table, base_dir, name);
    if (csv.empty())
        return system;
    Result<std::vector<ExplicitMode>> modes = parse_modes(csv, name);
    if (modes)
        system.modes = *std::move(modes);
    else
        table.fail(table.has("data") ? "data" : "file", modes.error().message);
    return system;
}

SineRamps read_sines(TomlTable& table) {
    SineRamps ramps;
    std::int64_t count = ramps.count;
    double spread_deg = ramps.direction_spread_rad * (180.0 / pi);
    table.choice("shape", ramps.kind, sine_names);
    table.number("length_m", ramps.length_m, {0.1, 1e6});
    table.integer("count", count, 1, 64);
    ramps.count = static_cast<int>(count);
    table.number("amplitude_m", ramps.amplitude_m, {0.0, 100.0});
    table.number("wavelength_m", ramps.wavelength_m, {0.01, 1e6});
    table.number("amplitude_ratio", ramps.amplitude_ratio, {0.01, 1.0});
    table.number("wavenumber_ratio", ramps.wavenumber_ratio, {1.0, 4.0});
    read_direction(table, ramps.towards_rad);
    if (table.number("direction_spread_deg", spread_deg, {0.0, 180.0}))
        ramps.direction_spread_rad = spread_deg * (pi / 180.0);
    table.flag("normalise", ramps.normalise);
    if (ramps.kind == SineKind::exponential) {
        table.number("speed_ratio", ramps.speed_ratio, {0.1, 10.0});
        table.number("sharpness", ramps.sharpness, {0.1, 10.0});
        table.number("drag", ramps.drag, {0.0, 2.0});
    }
    if (!(sine_steps(ramps) <= sine_steps_max))
        table.bad_value("wavenumber_ratio", fmt::format("{}", ramps.wavenumber_ratio),
                        fmt::format("ramps whose shortest wave fits the tile at most {} times; "
                                    "this one {:.3g} times",
                                    sine_steps_max, sine_steps(ramps)));
    return ramps;
}

enum class SystemType { wind, swell, measured, modes, sines };

void read_system(TomlTable& table, const std::string& base_dir, SeaState& sea) {
    if (table.has("preset")) {
        read_preset(table, sea, true);
        return;
    }
    auto type = SystemType::wind;
    table.require("type");
    if (!table.choice("type", type,
                      {{"wind", SystemType::wind},
                       {"swell", SystemType::swell},
                       {"measured", SystemType::measured},
                       {"modes", SystemType::modes},
                       {"sines", SystemType::sines}}))
        return;
    switch (type) {
    case SystemType::wind:
        sea.systems.emplace_back(read_wind_sea(table, sea.gravity_mps2));
        return;
    case SystemType::swell:
        sea.systems.emplace_back(read_swell(table));
        return;
    case SystemType::measured:
        sea.systems.emplace_back(read_measured(table, base_dir));
        return;
    case SystemType::modes:
        sea.systems.emplace_back(read_modes(table, base_dir));
        return;
    case SystemType::sines:
        sea.systems.emplace_back(read_sines(table));
        return;
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
    for (TomlTable& table : sea_table.tables("system", scene_systems_max)) {
        read_system(table, base_dir, sea);
        table.finish();
    }
}

} // namespace seaway::sea
