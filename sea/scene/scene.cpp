// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "base/text_file.h"
#include "base/toml_document.h"
#include "sea/basics/glide.h"
#include "sea/scene/scene_names.h"
#include "sea/scene/scene_systems.h"
#include "sea/scene/weather.h"

namespace seaway::sea {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

void read_sea(TomlTable& table, const std::string& base_dir, SeaState& sea) {
    std::int64_t seed = 0;
    table.integer("seed", seed, 0, std::numeric_limits<std::int64_t>::max());
    sea.seed = static_cast<std::uint64_t>(seed);
    table.number("depth_m", sea.depth_m, {0.01, infinite});
    table.number_or_pair("choppiness", sea.choppiness.x, sea.choppiness.y, {0.0, 3.0});
    table.number("gravity_mps2", sea.gravity_mps2, {0.1, 100.0});
    table.flag("surface_tension", sea.surface_tension);
    if (table.number("loop_period_s", sea.loop_period_s, {0.0, 1e6}) && sea.loop_period_s > 0.0 &&
        sea.loop_period_s < 1.0)
        table.bad_value("loop_period_s", fmt::format("{}", sea.loop_period_s),
                        "0 (never repeats), or a number 1 .. 1e6");
    table.number("height_scale", sea.height_scale, {0.0, 10.0});
    table.number("short_wave_fade_m", sea.short_wave_fade_m, {0.0, 1000.0});
    table.number("wavenumber_min_radpm", sea.wavenumber_min_radpm, {0.0, 1e4});
    table.number("wavenumber_max_radpm", sea.wavenumber_max_radpm, {0.0, infinite});
    read_preset(table, sea, false);
    read_systems(table, base_dir, sea);
    table.finish();
}

/// docs/decisions/0014-square-tiles.md.
constexpr std::string_view why_square =
    "tiles are square, one number: the lattice is the same along x and y, so that a wave is as "
    "finely resolved whichever way it runs; several cascades carry several lengths";

/// `cascades` holds what is taken where the scene has none.
void read_cascades(TomlTable& root, std::vector<CascadeSpec>& cascades) {
    if (root.has("cascade"))
        cascades.clear();
    if (root.is_empty_array("cascade"))
        root.bad_value("cascade", "an empty array",
                       fmt::format("1 .. {} tables, each [[cascade]]; without the key the default "
                                   "tiles",
                                   scene_cascades_max));
    for (TomlTable& table : root.tables("cascade", scene_cascades_max)) {
        CascadeSpec cascade{1000.0, 256};
        std::int64_t size = 0;
        table.require("length_m");
        table.require("size");
        if (table.is_array("length_m"))
            table.fail("length_m", std::string(why_square));
        table.number("length_m", cascade.length_m, {0.1, 1e6});
        if (table.integer("size", size, 16, 2048) && (size & (size - 1)) != 0)
            table.bad_value("size", fmt::format("{}", size), "a power of two 16 .. 2048");
        cascade.size = static_cast<int>(size);
        table.finish();
        cascades.push_back(cascade);
    }
}

/// A name that the writer can write back between quotes.
void read_certificate_name(TomlTable& table, const std::string& base_dir, CertificateFile& file) {
    constexpr std::size_t name_bytes_max = 1024;
    std::string name;
    if (!table.text("certificate", name))
        return;
    const auto unfit = [](char c) {
        return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    };
    if (name.empty() || name.size() > name_bytes_max ||
        std::any_of(name.begin(), name.end(), unfit))
        return table.bad_value(
            "certificate", name.empty() ? "\"\"" : "this name",
            fmt::format("the name of a file beside the scene, 1 .. {} bytes without quotes, "
                        "backslashes and control characters",
                        name_bytes_max));
    file = {name, (std::filesystem::path(base_dir) / name).string()};
}

void read_rest(TomlTable& root, Scene& scene) {
    if (auto table = root.table("effects")) {
        table->choice("displacement", scene.effects.choppy, {{"height", false}, {"choppy", true}});
        table->flag("slopes", scene.effects.slopes);
        table->flag("foam", scene.effects.foam);
        bool velocity = true; // there is no other: see docs/decisions/0005
        if (table->flag("velocity", velocity) && !velocity)
            table->bad_value("velocity", "false",
                             "true, or leave the key out: time rates join the keyframes of "
                             "heights and displacements, so leaving them out would save nothing");
        table->finish();
    }
    if (auto table = root.table("foam")) {
        bool observed = true;
        table->choice("coverage", observed, {{"observed", true}});
        if (double threshold = 0.0; table->number("threshold", threshold, {-1.0, 1.0}))
            scene.foam.threshold = threshold; // wins over coverage
        table->number("decay_s", scene.foam.decay_s, {0.0, 1e6});
        table->number("gain_per_s", scene.foam.gain_per_s, {0.0, 1000.0});
        table->number("bias", scene.foam.bias, {0.0, 1.0});
        table->finish();
    }
    if (auto table = root.table("water")) {
        table->choice("type", scene.water.type, water_types);
        table->triple("bottom_albedo", scene.water.bottom_albedo, {0.0, 1.0});
        table->finish();
    }
}

/// A preset first: what else the scene says wins over it.
void read_accuracy(TomlTable& root, const std::string& base_dir, Scene& scene) {
    scene.cascades = {{1021.0, 256}, {197.0, 256}, {37.0, 256}};
    if (auto table = root.table("accuracy")) {
        AccuracyPreset preset{};
        if (table->choice("preset", preset, accuracy_preset_names)) {
            PresetAccuracy accuracy = accuracy_of(preset);
            scene.accuracy.preset = preset;
            scene.accuracy.height_error_m = accuracy.height_error_m;
            scene.cascades = std::move(accuracy.cascades);
        }
        table->number("height_error_m", scene.accuracy.height_error_m, {1e-5, 1.0});
        read_certificate_name(*table, base_dir, scene.accuracy.certificate);
        table->finish();
    }
}

void read_weather(TomlTable& root, Scene& scene) {
    constexpr double latest_s = 1e10;
    double free_from_s = -latest_s;
    for (TomlTable& table : root.tables("weather", scene_weather_max)) {
        WeatherChange change;
        table.require("at_s");
        table.require("set");
        if (free_from_s > latest_s)
            table.fail("at_s", fmt::format("the row before ends at {:g} s, and none may begin "
                                           "after {:g}",
                                           free_from_s, latest_s));
        else
            table.number("at_s", change.at_s, {free_from_s, latest_s});
        table.number("over_s", change.over_s,
                     {seconds_from_us(glide_us_min), seconds_from_us(glide_us_max)});
        table.assignments("set", change.set);
        change.line = table.line_of("set");
        table.finish();
        // Of doubles 2.3 + 11.3 is more than 13.6.
        free_from_s =
            seconds_from_us(us_from_seconds(change.at_s) + us_from_seconds(change.over_s));
        scene.weather.push_back(std::move(change));
    }
}

/// The cascades, and one more for each length of explicit and stylised waves that none of them has.
int tiles_of(const Scene& scene) {
    std::vector<double> lengths;
    for (const CascadeSpec& cascade : scene.cascades)
        lengths.push_back(cascade.length_m);
    for (const WaveSystem& system : scene.sea.systems) {
        const double length_m = explicit_length_m(system);
        const auto same = [length_m](double held) { return same_tile_length(held, length_m); };
        if (length_m > 0.0 && std::none_of(lengths.begin(), lengths.end(), same))
            lengths.push_back(length_m);
    }
    return static_cast<int>(lengths.size());
}

} // namespace

Result<Scene> parse_scene(std::string_view text, const std::string& name,
                          const std::string& base_dir) {
    if (text.size() > scene_text_bytes_max)
        return Error{fmt::format("{}: {} bytes; a scene has at most {}", name, text.size(),
                                 scene_text_bytes_max)};
    const Result<TomlDocument> document = TomlDocument::parse(text, name);
    if (!document)
        return document.error();
    Scene scene;
    scene.source = name;
    scene.folder = base_dir;
    TomlErrors errors(name);
    TomlTable root = document.value().root(errors);
    root.require("sea");
    if (auto table = root.table("sea"))
        read_sea(*table, base_dir, scene.sea);
    read_accuracy(root, base_dir, scene);
    read_cascades(root, scene.cascades);
    read_rest(root, scene);
    read_weather(root, scene);
    root.finish();
    if (errors.first())
        return *errors.first();
    if (const Result<std::vector<Band>> bands = assign_bands(scene.cascades); !bands)
        return Error{fmt::format("{}: {}", name, bands.error().message)};
    if (const int tiles = tiles_of(scene); tiles > scene_cascades_max)
        return Error{fmt::format("{}: waves given one by one stand on tiles of their own: with "
                                 "{} cascades there are {} tiles; allowed: at most {}",
                                 name, scene.cascades.size(), tiles, scene_cascades_max)};
    if (const std::size_t written = to_toml(scene).size(); written > scene_text_bytes_max)
        return Error{
            fmt::format("{}: sea.system: written whole, with the tables that its files hold, "
                        "the scene has {} bytes; allowed: at most {}",
                        name, written, scene_text_bytes_max)};
    if (const Result<std::vector<Scene>> weather = weather_scenes(scene); !weather)
        return weather.error();
    return scene;
}

Result<Scene> read_scene(const std::string& path) {
    const Result<std::string> text = read_text_file(path, scene_text_bytes_max);
    if (!text)
        return Error{fmt::format("cannot read scene '{}': {}", path, text.error().message)};
    return parse_scene(*text, path, std::filesystem::path(path).parent_path().string());
}

namespace {

using Realize = Result<Realization> (*)(const SeaState&, std::span<const CascadeSpec>);

Result<Realization> realized_by(Realize function, const Scene& scene) {
    SeaState sea = scene.sea;
    if (!scene.effects.choppy)
        sea.choppiness = {0.0, 0.0}; // nothing moves sideways, for the exact sum as for the maps
    Result<Realization> realized = function(sea, scene.cascades);
    if (!realized && !scene.source.empty())
        return Error{fmt::format("{}: {}", scene.source, realized.error().message)};
    return realized;
}

} // namespace

Result<Realization> realize(const Scene& scene) {
    return realized_by(realize, scene);
}

Result<Realization> realize_clocks(const Scene& scene) {
    return realized_by(realize_clocks, scene);
}

} // namespace seaway::sea
