// SPDX-License-Identifier: Apache-2.0
#include "sea/scene/weather.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "sea/scene/scene_tables.h"

namespace seaway::sea {

namespace {

constexpr std::string_view systems_path = "sea.system.";

/// As people say it: the systems of the sea. A preset of the whole sea is that of its one system, which it became when the
/// scene was read.
std::string whole_path(const std::string& path, std::size_t systems) {
    constexpr std::string_view said = "systems.";
    if (systems == 1 && (path == "sea.preset" || path == "sea.from_deg"))
        return "sea.system.0." + path.substr(path.rfind('.') + 1);
    return path.starts_with(said) ? std::string(systems_path) + path.substr(said.size()) : path;
}

/// Of two keys of a system that exclude each other, the one that is set stands in place of the other.
constexpr std::pair<std::string_view, std::string_view> exclusive_keys[] = {
    {"wind_speed_10m_mps", "wind_speed_19m5_mps"},
    {"phillips_constant", "significant_height_m"},
    {"file", "data"}};

/// Of the systems that a scene may have.
bool is_system(std::string_view number) {
    int value = -1;
    const auto [end, fault] = std::from_chars(number.begin(), number.end(), value);
    return number.size() <= 2 && fault == std::errc{} && end == number.end() && value >= 0 &&
           value < scene_systems_max;
}

/// Keys of the effective text in whose place stands what is set at this path. The text is read for those alone that are set once
/// for each of a few systems.
std::vector<std::string> keys_replaced_by(const std::string& path, std::string_view text) {
    if (path == "foam.coverage")
        return {"foam.threshold"}; // which would win over it
    const std::size_t dot = path.rfind('.');
    if (!path.starts_with(systems_path) || dot <= systems_path.size())
        return {};
    const std::string table = path.substr(0, dot);
    const std::string_view key = std::string_view(path).substr(dot + 1);
    std::vector<std::string> held;
    if ((key == "file" || key == "data" || key == "preset") &&
        is_system(std::string_view(table).substr(systems_path.size())))
        held = toml_keys(text, table);
    std::vector<std::string> replaced;
    const auto replace = [&](std::string_view one) {
        replaced.push_back(fmt::format("{}.{}", table, one));
    };
    for (const auto& [a, b] : exclusive_keys)
        if (key == a || key == b)
            replace(key == a ? b : a);
    if ((key == "file" || key == "data") && std::ranges::count(held, sine_ramp_keys.front()) > 0)
        std::ranges::for_each(sine_ramp_keys, replace);
    if (key == "preset")
        for (const std::string& one : held)
            if (one != "from_deg")
                replace(one);
    return replaced;
}

/// The effective text with all tables that a path may lead to: one is not written while it says nothing.
std::string text_with_tables(const Scene& scene, std::span<const TomlAssignment> values) {
    std::string text = to_toml(scene);
    const bool sets_water = std::ranges::any_of(
        values, [](const TomlAssignment& value) { return value.path.starts_with("water."); });
    if (sets_water && scene.water == Water{})
        text += "\n[water]\n";
    return text;
}

/// What is wrong with a changed scene, in the words of who changed it: without a line of a text that nobody has, and tables by
/// their paths, which count from 0.
std::string as_asked(std::string why, const std::string& name) {
    if (why.starts_with(name + ":"))
        why.erase(0, name.size() + 1);
    if (const std::size_t digits = why.find_first_not_of("0123456789");
        digits != std::string::npos && digits > 0 && why[digits] == ':')
        why.erase(0, digits + 1);
    why.erase(0, why.find_first_not_of(' '));
    for (const std::string_view table : {"sea.system", "cascade"})
        for (std::size_t at = 0;
             (at = why.find(fmt::format("{}[", table), at)) != std::string::npos; ++at) {
            const std::size_t first = at + table.size() + 1;
            int number = 0;
            const auto [end, fault] = std::from_chars(&why[first], why.data() + why.size(), number);
            if (fault == std::errc{} && *end == ']')
                why.replace(at, static_cast<std::size_t>(end - why.data()) + 1 - at,
                            fmt::format("{}.{}", table, number - 1));
        }
    return why;
}

bool same_cascades(const Scene& a, const Scene& b) {
    if (a.cascades.size() != b.cascades.size())
        return false;
    for (std::size_t c = 0; c < a.cascades.size(); ++c)
        if (a.cascades[c].length_m != b.cascades[c].length_m ||
            a.cascades[c].size != b.cascades[c].size)
            return false;
    return true;
}

bool same_effects(const Effects& a, const Effects& b) {
    return a.choppy == b.choppy && a.slopes == b.slopes && a.foam == b.foam;
}

} // namespace

Result<void> check_glide(const Scene& from, const Scene& to) {
    const char* stays = nullptr;
    if (!same_cascades(from, to))
        stays = "cascade";
    else if (!same_effects(from.effects, to.effects))
        stays = "effects";
    else if (from.accuracy.height_error_m != to.accuracy.height_error_m ||
             from.accuracy.preset != to.accuracy.preset)
        stays = "accuracy";
    else if (from.sea.loop_period_s != to.sea.loop_period_s)
        stays = "sea.loop_period_s";
    else if (from.foam.decay_s != to.foam.decay_s)
        stays = "foam.decay_s";
    if (to.sea.loop_period_s > 0)
        return Error{"a sea that repeats (sea.loop_period_s) cannot change"};
    if (stays)
        return Error{fmt::format("{} cannot change while the sea runs: restart the server with the "
                                 "other scene",
                                 stays)};
    return {};
}

Result<Scene> changed(const Scene& scene, std::span<const TomlAssignment> values) {
    Scene still = scene;
    still.weather.clear();
    std::vector<TomlAssignment> whole(values.begin(), values.end());
    std::vector<std::string> replaced;
    std::set<std::string> set;
    const std::string text_before = to_toml(still);
    for (TomlAssignment& value : whole) {
        value.path = whole_path(value.path, scene.sea.systems.size());
        if (value.path == "sea.preset" && !scene.sea.systems.empty())
            return Error{fmt::format("sea.preset: would stand beside the {} systems of the sea: "
                                     "set sea.system.0.preset, or that of another",
                                     scene.sea.systems.size())};
        if (!set.insert(value.path).second)
            return Error{fmt::format("{}: is set twice", value.path)};
        if (value.path == "weather" || value.path.starts_with("weather."))
            return Error{
                fmt::format("{}: a change is of the sea, not of its timetable", value.path)};
        std::ranges::move(keys_replaced_by(value.path, text_before), std::back_inserter(replaced));
    }
    SEAWAY_TRY_LET(const std::string text,
                   with_toml_values(text_with_tables(still, whole), scene.source, whole, replaced));
    const std::string name = scene.source + " as changed";
    Result<Scene> read = parse_scene(text, name, scene.folder);
    if (!read)
        return Error{as_asked(read.error().message, name)};
    Scene next = *std::move(read);
    next.source = scene.source;
    SEAWAY_TRY(check_glide(scene, next));
    return next;
}

Result<std::vector<Scene>> weather_scenes(const Scene& scene) {
    std::vector<Scene> scenes;
    for (std::size_t i = 0; i < scene.weather.size(); ++i) {
        Result<Scene> next = changed(i == 0 ? scene : scenes.back(), scene.weather[i].set);
        if (!next)
            return Error{fmt::format(
                "{}:{} weather[{}]: {}", scene.source,
                scene.weather[i].line > 0 ? fmt::format("{}:", scene.weather[i].line) : "", i + 1,
                next.error().message)};
        scenes.push_back(*std::move(next));
    }
    return scenes;
}

Result<Scene> weather_by(const Scene& scene, TimeUs time_us) {
    std::size_t begun = 0;
    while (begun < scene.weather.size() && us_from_seconds(scene.weather[begun].at_s) <= time_us)
        ++begun;
    if (begun == 0)
        return scene;
    Scene so_far = scene;
    so_far.weather.resize(begun);
    SEAWAY_TRY_LET(std::vector<Scene> scenes, weather_scenes(so_far));
    Scene by_then = std::move(scenes.back());
    by_then.weather.assign(scene.weather.begin() + static_cast<std::ptrdiff_t>(begun),
                           scene.weather.end());
    return by_then;
}

} // namespace seaway::sea
