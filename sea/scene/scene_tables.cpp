// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/scene_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include <fmt/format.h>

#include "base/csv_table.h"
#include "base/text_file.h"
#include "sea/scene/scene.h"
#include "sea/scene/scene_names.h"
#include "sea/spectrum/ndbc.h"

namespace seaway::sea {

namespace {

constexpr std::size_t modes_max = 65536;

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

/// The file under `key`; empty on error.
std::string read_named(TomlTable& table, std::string_view key, const std::string& base_dir,
                       std::size_t bytes_max, std::string& name) {
    if (!table.text(key, name))
        return {};
    if (base_dir == no_files) {
        table.fail(key, "this text may name no file; it holds its tables under 'data'");
        return {};
    }
    const std::filesystem::path path = std::filesystem::path(base_dir) / name;
    const Result<std::string> text = read_text_file(path.string(), bytes_max);
    if (!text)
        table.bad_value(key, '"' + path.string() + '"',
                        fmt::format("a readable file of at most {} bytes; this one: {}", bytes_max,
                                    text.error().message));
    else if (text->empty())
        table.fail(key, path.string() + " is empty");
    return text ? *text : std::string();
}

const char* data_key(const TomlTable& table) {
    return table.has("data") ? "data" : "file";
}

struct NdbcKey {
    const char* key;
    std::optional<NdbcText> NdbcTexts::*text;
};
constexpr std::array<NdbcKey, 4> ndbc_keys{{{"alpha1_file", &NdbcTexts::alpha1},
                                            {"r1_file", &NdbcTexts::r1},
                                            {"alpha2_file", &NdbcTexts::alpha2},
                                            {"r2_file", &NdbcTexts::r2}}};

/// The files of a buoy of NDBC as a table of ours. Empty on error.
std::string read_ndbc(TomlTable& table, const std::string& base_dir, NdbcText density) {
    NdbcTexts texts;
    texts.density = std::move(density);
    for (const auto& [key, text] : ndbc_keys) {
        if (!table.has(key))
            continue;
        NdbcText& file = (texts.*text).emplace();
        file.text = read_named(table, key, base_dir, ndbc_bytes_max, file.name);
        if (file.text.empty())
            return {};
    }
    std::string time_utc;
    table.text("time_utc", time_utc);
    if (texts.alpha1.has_value() != texts.r1.has_value() ||
        texts.alpha2.has_value() != texts.r2.has_value() || (texts.r2 && !texts.r1)) {
        table.fail("file", "directions need alpha1_file and r1_file, or these and alpha2_file and "
                           "r2_file");
        return {};
    }
    const Result<std::string> csv = ndbc_to_csv(texts, time_utc);
    if (!csv)
        table.fail("file", csv.error().message);
    return csv ? *csv : std::string();
}

void refuse_ndbc_keys(TomlTable& table) {
    const char* why = "only beside a file of densities as NDBC publishes it (its first line begins "
                      "with #YY MM DD)";
    for (const NdbcKey& row : ndbc_keys)
        table.refuse(row.key, why);
    table.refuse("time_utc", why);
}

} // namespace

std::string read_data(TomlTable& table, const std::string& base_dir, std::size_t bytes_max,
                      std::string& name) {
    name = "data";
    if (!table.has("data")) {
        table.require("file");
        return read_named(table, "file", base_dir, bytes_max, name);
    }
    table.refuse("file", "excludes data: give one of the two");
    std::string text;
    if (table.text("data", text) && text.empty())
        table.fail("data", "is empty");
    return text;
}

MeasuredSea read_measured(TomlTable& table, const std::string& base_dir) {
    MeasuredSea sea;
    std::string name;
    sea.csv = read_data(table, base_dir, ndbc_bytes_max, name);
    if (sea.csv.empty())
        return sea;
    if (!table.has("data") && is_ndbc(sea.csv)) {
        sea.csv = read_ndbc(table, base_dir, {sea.csv, name});
        if (sea.csv.empty())
            return sea;
    } else {
        refuse_ndbc_keys(table);
    }
    const std::string written = std::exchange(sea.csv, without_notes(sea.csv));
    if (sea.csv.size() > scene_text_bytes_max) {
        table.fail(data_key(table),
                   fmt::format("{}: a table has at most {} bytes without its notes", name,
                               scene_text_bytes_max));
        return sea;
    }
    CoefficientFrame frame = CoefficientFrame::from_clockwise_north;
    if (table.choice("coefficients", frame, frame_names))
        sea.coefficients = frame;
    Result<MeasuredSpectrum> spectrum = parse_measured(written, name, frame);
    if (!spectrum) {
        table.fail(data_key(table), spectrum.error().message);
        return sea;
    }
    if (!spectrum->quality.has_coefficients)
        table.refuse("coefficients", "only for a table with the columns a1,b1");
    if (!spectrum->has_directions()) {
        read_direction(table, sea.towards_rad);
        sea.spreading = read_spreading(table, {});
    } else {
        for (const char* key :
             {"from_deg", "spreading", "spreading_exponent", "narrow_share", "swell", "isotropic"})
            table.refuse(key, "the table has directions of its own");
    }
    sea.spectrum = std::make_shared<const MeasuredSpectrum>(*std::move(spectrum));
    return sea;
}

namespace {

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

} // namespace

ExplicitModes read_modes(TomlTable& table, const std::string& base_dir) {
    ExplicitModes system;
    table.require("length_m");
    table.number("length_m", system.length_m, {0.1, 1e6});
    std::string name;
    const std::string csv = read_data(table, base_dir, scene_text_bytes_max, name);
    if (csv.empty())
        return system;
    Result<std::vector<ExplicitMode>> modes = parse_modes(csv, name);
    if (modes)
        system.modes = *std::move(modes);
    else
        table.fail(data_key(table), modes.error().message);
    return system;
}

} // namespace seaway::sea
