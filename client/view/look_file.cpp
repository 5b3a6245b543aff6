// SPDX-License-Identifier: Apache-2.0
#include "client/view/look_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "base/messages.h"
#include "base/text_file.h"
#include "base/whole_file.h"
#include "client/view/look_keys.h"

namespace seaway::client {

namespace {

constexpr std::size_t path_bytes_max = 1024;

std::optional<double> number_of(std::string_view text) {
    double value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

/// The number of a file that reads back as this one of a look: a product may be off by a last bit.
double in_units(double value, double unit) {
    double up = value / unit, down = up;
    for (int step = 0; step < 8; ++step) {
        if (up * unit == value)
            return up;
        if (down * unit == value)
            return down;
        up = std::nextafter(up, INFINITY);
        down = std::nextafter(down, -INFINITY);
    }
    return value / unit;
}

/// The place, which is there once one of its keys is.
PlaceAndTime& place_of(Look& look) {
    if (!look.place)
        look.place.emplace();
    return *look.place;
}

void read_utc(TomlTable& table, std::string_view key, Look& look) {
    std::string text;
    if (!table.text_or_instant(key, text))
        return;
    if (const Result<Instant> when = parse_instant(text))
        place_of(look).when = *when;
    else
        table.fail(key, when.error().message);
}

void read_exposure(TomlTable& table, std::string_view key, Look& look) {
    if (std::string text; table.is_text(key) && table.text(key, text)) {
        if (const Result<Exposure> exposure = parse_exposure(text))
            look.exposure = *exposure;
        else
            table.fail(key, exposure.error().message);
    } else if (double factor = 0; table.number(key, factor, exposure_factors)) {
        look.exposure = {Exposure::By::factor, factor};
    }
}

/// One that stands in a look between quotes.
bool is_sky_name(const std::string& name) {
    return !name.empty() && name.size() <= path_bytes_max &&
           name.find_first_of("\"\\") == std::string::npos && is_printable(name);
}
std::string sky_names() {
    return fmt::format("the name of a file, 1 .. {} bytes of UTF-8 without quotes, backslashes and "
                       "control characters",
                       path_bytes_max);
}

/// Tables of a computed sky.
constexpr std::array<std::string_view, 2> computed_sky_tables{"time", "clouds"};

bool counts(const LookKey& row, const Look& look) {
    if (row.table == "sky")
        return !look.environment.empty();
    return look.environment.empty() ||
           std::find(computed_sky_tables.begin(), computed_sky_tables.end(), row.table) ==
               computed_sky_tables.end();
}

void read_environment_name(TomlTable& table, std::string_view key, const std::string& base_dir,
                           Look& look) {
    std::string name;
    if (!table.text(key, name))
        return;
    if (!is_sky_name(name))
        return table.bad_value(key, name.empty() ? "\"\"" : "this name", sky_names());
    look.environment = (std::filesystem::path(base_dir) / name).lexically_normal().string();
}

void read_word(TomlTable& table, std::string_view key, LookWord word, const std::string& base_dir,
               Look& look) {
    double angle_deg = 0;
    switch (word) {
    case LookWord::hour:
        table.number(key, look.hour, hours);
        break;
    case LookWord::latitude:
        if (table.number(key, angle_deg, latitudes_deg))
            place_of(look).latitude_deg = angle_deg;
        break;
    case LookWord::longitude:
        if (table.number(key, angle_deg, longitudes_deg))
            place_of(look).longitude_deg = angle_deg;
        break;
    case LookWord::utc:
        read_utc(table, key, look);
        break;
    case LookWord::exposure:
        read_exposure(table, key, look);
        break;
    case LookWord::environment:
        read_environment_name(table, key, base_dir, look);
        break;
    case LookWord::water:
        if (sea::WaterType type{}; table.choice(key, type, sea::water_types))
            look.water = type;
        break;
    case LookWord::bottom:
        if (std::array<double, 3> albedo{}; table.triple(key, albedo, albedos))
            look.bottom_albedo = albedo;
        break;
    }
}

void read_key(TomlTable& table, const LookKey& row, const std::string& base_dir, Look& look) {
    if (const auto* number = std::get_if<LookNumber>(&row.value)) {
        if (double value = 0; table.number(row.key, value, number->range))
            number->of(look) = value * number->unit;
    } else if (const auto* triple = std::get_if<LookTriple>(&row.value)) {
        if (std::array<double, 3> v{}; table.triple(row.key, v, triple->range))
            triple->of(look) = {v[0], v[1], v[2]};
    } else {
        read_word(table, row.key, std::get<LookWord>(row.value), base_dir, look);
    }
}

/// An hour, or a place and an instant, whole.
void check_time(TomlTable& table, const Look& look) {
    constexpr const char* of_place[] = {"latitude_deg", "longitude_deg", "utc"};
    if (!look.place)
        return;
    if (table.has("hour"))
        table.fail("hour", "not beside a place: the hour follows from it and utc");
    for (const char* key : of_place)
        table.require(key);
}

std::string value_of(const LookKey& row, Look& look) {
    if (const auto* number = std::get_if<LookNumber>(&row.value))
        return fmt::format("{}", in_units(number->of(look), number->unit));
    if (const auto* triple = std::get_if<LookTriple>(&row.value)) {
        const glm::dvec3& v = triple->of(look);
        return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
    }
    switch (std::get<LookWord>(row.value)) {
    case LookWord::hour:
        return look.place ? "" : fmt::format("{}", look.hour);
    case LookWord::latitude:
        return look.place ? fmt::format("{}", look.place->latitude_deg) : "";
    case LookWord::longitude:
        return look.place ? fmt::format("{}", look.place->longitude_deg) : "";
    case LookWord::utc:
        return look.place ? to_text(look.place->when) : "";
    case LookWord::exposure:
        return look.exposure.by == Exposure::By::factor ? to_text(look.exposure)
                                                        : '"' + to_text(look.exposure) + '"';
    case LookWord::environment:
        return look.environment.empty() ? "" : '"' + look.environment + '"';
    case LookWord::water:
        return look.water ? fmt::format("\"{}\"", sea::name_of(*look.water)) : "";
    case LookWord::bottom:
        break;
    }
    if (!look.bottom_albedo)
        return "";
    const auto& [red, green, blue] = *look.bottom_albedo;
    return fmt::format("[{}, {}, {}]", red, green, blue);
}

} // namespace

Result<Look> parse_look(std::string_view text, const std::string& name,
                        const std::string& base_dir) {
    if (text.size() > look_text_bytes_max)
        return Error{fmt::format("{}: {} bytes; a look has at most {}", name, text.size(),
                                 look_text_bytes_max)};
    const Result<TomlDocument> document = TomlDocument::parse(text, name);
    if (!document)
        return document.error();
    Look look;
    TomlErrors errors(name);
    TomlTable root = document->root(errors);
    const std::span<const LookKey> keys = look_keys();
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const std::string_view heading = keys[i].table;
        if (i > 0 && keys[i - 1].table == heading)
            continue;
        std::optional<TomlTable> table = root.table(heading);
        if (!table)
            continue;
        for (const LookKey& row : keys.subspan(i))
            if (row.table == heading)
                read_key(*table, row, base_dir, look);
        if (heading == "time")
            check_time(*table, look);
        if (heading == "sky" && look.environment.empty())
            table->refuse("turn_deg", "not without environment, the picture that it turns");
        table->finish();
    }
    if (!look.environment.empty())
        for (const std::string_view heading : computed_sky_tables)
            root.refuse(heading, "not beside sky.environment: its picture is the sky");
    root.finish();
    if (errors.first())
        return *errors.first();
    return look;
}

Result<Look> read_look(const std::string& path) {
    const Result<std::string> text = read_text_file(path, look_text_bytes_max);
    if (!text)
        return Error{fmt::format("cannot read look '{}': {}", path, text.error().message)};
    return parse_look(*text, path, std::filesystem::path(path).parent_path().string());
}

Look in_force(Look look) {
    const Look plain;
    if (look.environment.empty()) {
        look.environment_turn_deg = plain.environment_turn_deg;
    } else {
        look.clouds = plain.clouds;
        look.hour = plain.hour;
        look.place.reset();
    }
    if (look.place)
        look.hour = plain.hour;
    return look;
}

std::string to_toml(const Look& look) {
    Look copy = in_force(look);
    std::string out;
    std::string_view heading;
    for (const LookKey& row : look_keys()) {
        const std::string value = counts(row, copy) ? value_of(row, copy) : "";
        if (value.empty())
            continue;
        if (row.table != heading)
            out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", row.table);
        heading = row.table;
        out += fmt::format("{} = {}\n", row.key, value);
    }
    return out;
}

Result<void> write_look(const Look& look, const std::string& path) {
    const auto failed = [&](const std::string& why) {
        return Error{fmt::format("cannot write look '{}': {}", path, why)};
    };
    if (path.empty())
        return failed("no name");
    Look beside_it = look;
    if (!look.environment.empty()) {
        namespace fs = std::filesystem;
        const fs::path from = fs::absolute(path).parent_path();
        beside_it.environment = fs::absolute(look.environment)
                                    .lexically_normal()
                                    .lexically_proximate(from.lexically_normal());
        if (!is_sky_name(beside_it.environment))
            return failed("sky.environment: this name is not allowed; allowed: " + sky_names());
    }
    const Result<void> written = write_whole_file(path, to_toml(beside_it));
    return written ? written : failed(written.error().message);
}

Result<Exposure> parse_exposure(std::string_view text) {
    constexpr std::string_view unit = "ev";
    if (text == "auto")
        return Exposure{};
    const bool by_value = text.ends_with(unit);
    const Range& range = by_value ? exposure_values : exposure_factors;
    const std::optional<double> value =
        number_of(by_value ? text.substr(0, text.size() - unit.size()) : text);
    if (!value || !range.contains(*value))
        return Error{fmt::format("\"{}\" is not allowed; allowed: auto (metered), {:g}ev .. {:g}ev "
                                 "(as a camera is set, ISO 100), or a factor {:g} .. {:g}",
                                 text, exposure_values.lo, exposure_values.hi, exposure_factors.lo,
                                 exposure_factors.hi)};
    return Exposure{by_value ? Exposure::By::exposure_value : Exposure::By::factor, *value};
}

std::string to_text(const Exposure& exposure) {
    switch (exposure.by) {
    case Exposure::By::meter:
        return "auto";
    case Exposure::By::exposure_value:
        return fmt::format("{}ev", exposure.value);
    case Exposure::By::factor:
        break;
    }
    return fmt::format("{}", exposure.value);
}

std::optional<double> fixed_exposure(const Exposure& exposure) {
    constexpr double grey = 0.18, meter_kcdpm2 = 12.5 / 100 / 1000; // at EV 0 and ISO 100
    switch (exposure.by) {
    case Exposure::By::meter:
        return std::nullopt;
    case Exposure::By::exposure_value:
        return grey / (meter_kcdpm2 * std::exp2(exposure.value));
    case Exposure::By::factor:
        break;
    }
    return exposure.value;
}

double exposure_of(const Look& look, double metered) {
    return fixed_exposure(look.exposure).value_or(metered) * std::exp2(look.exposure_stops);
}

void set_water(SeaFrame& frame, const Look& look) {
    if (look.water)
        frame.water.type = *look.water;
    if (look.bottom_albedo)
        frame.water.bottom_albedo = *look.bottom_albedo;
}

} // namespace seaway::client
