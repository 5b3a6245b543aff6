// SPDX-License-Identifier: Apache-2.0
#include "server/following.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sea/basics/time.h"
#include "sea/scene/weather.h"
#include "server/host/metrics_text.h"
#include "server/scene_difference.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

double Following::clock_budget_us() const {
    return vertical_mps > 0 ? 1e6 * height_error_m / vertical_mps : 1e12;
}

Doubt Following::kind_of_doubt() const {
    if (writing_us > writing_us_max)
        return Doubt::writing;
    if (!shared)
        return Doubt::none;
    if (!stuck.empty())
        return Doubt::stuck;
    if (!journal.current)
        return Doubt::unheard;
    const double off_us = std::abs(journal.peers.ahead_us);
    // What it is off by for certain: a long way to the peers is no reason.
    if (journal.peers.can_judge() && off_us - journal.peers.error_us > clock_budget_us())
        return Doubt::clock;
    if (ahead_us > ahead_us_max)
        return Doubt::ahead;
    return late || behind_us > behind_us_max ? Doubt::behind : Doubt::none;
}

std::string in_general(Doubt doubt) {
    switch (doubt) {
    case Doubt::stuck:
    case Doubt::unheard:
        return "the journal cannot be followed";
    case Doubt::clock:
        return "its clock is not that of the others";
    case Doubt::writing:
        return "a change is still under way to the journal";
    case Doubt::ahead:
    case Doubt::behind:
        return "its sea is not that of the others yet";
    case Doubt::none:
        break;
    }
    return {};
}

std::string Following::doubt() const {
    const double off_us = std::abs(journal.peers.ahead_us);
    switch (kind_of_doubt()) {
    case Doubt::stuck:
        return stuck;
    case Doubt::unheard:
        return fmt::format("the journal has not been heard of for {:.1f} s{}",
                           sea::seconds_from_us(journal.unheard_us),
                           journal.trouble.empty() ? "" : " (" + journal.trouble + ")");
    case Doubt::clock:
        return fmt::format(
            "its clock is {:.1f} ms {} those of {} others: heights would be {:.0f} mm off, "
            "and {:.0f} mm are allowed",
            1e-3 * off_us, journal.peers.ahead_us > 0 ? "ahead of" : "behind", journal.peers.judges,
            1e-3 * off_us * vertical_mps, 1e3 * height_error_m);
    case Doubt::ahead:
        return fmt::format("it heard of a pace too late, and its sea is {:.3f} s ahead",
                           sea::seconds_from_us(ahead_us));
    case Doubt::writing:
        return fmt::format("a change has been under way to the journal for {:.1f} s",
                           sea::seconds_from_us(writing_us));
    case Doubt::behind:
        return fmt::format("{} of {} changes are played", played, journal.last_epoch);
    case Doubt::none:
        break;
    }
    return {};
}

std::string Following::json() const {
    const std::string why = doubt();
    // A world, or a file without its folder: who reads this need not know the machine.
    const nlohmann::ordered_json all{{"name", name.substr(name.rfind('/') + 1)},
                                     {"shared", shared},
                                     {"changes", journal.last_epoch},
                                     {"played", played},
                                     {"counted", counted},
                                     {"counted_max", changes_max},
                                     {"unheard_s", sea::seconds_from_us(journal.unheard_us)},
                                     {"peers", journal.peers.peers},
                                     {"clock_ahead_ms", 1e-3 * journal.peers.ahead_us},
                                     {"clock_error_ms", 1e-3 * journal.peers.error_us},
                                     {"clock_budget_ms", 1e-3 * clock_budget_us()},
                                     {"stale", !why.empty()},
                                     {"why", why}};
    return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string Following::metrics() const {
    MetricsText text;
    const auto add = [&](std::string_view family, std::string_view help, double value) {
        text.one(family, "gauge", help, value);
    };
    add("journal_changes", "Changes that the journal is known to hold.", journal.last_epoch);
    add("journal_changes_played", "Changes that are part of the sea.", played);
    add("journal_changes_counted", "Changes and rows of timetables that have begun or are to come.",
        static_cast<double>(counted));
    add("journal_changes_counted_max", "So many there may be: a change more is refused.",
        static_cast<double>(changes_max));
    if (!shared)
        return text.take();
    add("journal_unheard_seconds", "How long ago it was known that the journal holds no more.",
        sea::seconds_from_us(journal.unheard_us));
    add("peers", "Other servers of this log that this one compares its clock with.",
        journal.peers.peers);
    add("clock_ahead_seconds", "This sea's clock before the middle one of all servers.",
        1e-6 * journal.peers.ahead_us);
    add("clock_error_seconds", "Bound on the error of that.", 1e-6 * journal.peers.error_us);
    add("clock_budget_seconds", "A clock that is off by this moves heights by their budget.",
        1e-6 * clock_budget_us());
    add("sea_stale", "1 while this sea may not be that of the other servers: /v1/state says why.",
        doubt().empty() ? 0 : 1);
    return text.take();
}

namespace {

/// What a scene says other than another, some of it.
std::vector<std::string> some_differences(const std::string& before, const std::string& after) {
    constexpr std::size_t lines_max = 4;
    constexpr std::size_t line_bytes_max =
        240; // of a table; all of an answer has administered_bytes_max
    const std::vector<SceneDifference> all = scene_differences(before, after);
    std::vector<std::string> lines;
    for (const SceneDifference& one : all) {
        if (lines.size() == lines_max) {
            lines.push_back(fmt::format("and {} more", all.size() - lines_max));
            break;
        }
        std::string line = one.after ? fmt::format("{} = {}", one.path, *one.after)
                                     : fmt::format("no {}", one.path);
        if (line.size() > line_bytes_max)
            line.replace(line_bytes_max, std::string::npos, "...");
        lines.push_back(std::move(line));
    }
    return lines;
}

/// What a scene and its timetable have led to by then; without the rows to come, which a change takes over from.
std::string led_to(const std::string& text, sea::TimeUs time_us) {
    if (text.find("[[weather]]") == std::string::npos)
        return text;
    const Result<sea::Scene> scene = sea::parse_scene(text, "the journal");
    Result<sea::Scene> by_then = scene ? sea::weather_by(*scene, time_us) : scene;
    if (!by_then) // written by another version: as it stands
        return text;
    by_then->weather.clear();
    return sea::to_toml(*by_then);
}

/// The scene that runs when a change begins, of those before it.
std::string scene_before(std::span<const SeaChange> before, const SeaChange& change) {
    const auto earlier = std::find_if(before.rbegin(), before.rend(), [&](const SeaChange& one) {
        return runs_before(one, change.start_us);
    });
    return earlier == before.rend() ? std::string() : led_to(earlier->scene, change.start_us - 1);
}

} // namespace

bool runs_before(const SeaChange& change, sea::TimeUs time_us) {
    return changes_the_scene(change) && (change.epoch == 1 || change.start_us < time_us);
}

bool changes_the_scene(const SeaChange& change) {
    return !change.pace && !change.lapsed;
}

std::string history_json(std::span<const SeaChange> changes, std::uint32_t from) {
    nlohmann::ordered_json listed = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < changes.size(); ++i) {
        const SeaChange& change = changes[i];
        const bool wanted = change.epoch >= from && listed.size() < history_max;
        if (change.pace && wanted)
            listed.push_back({{"change", change.epoch},
                              {"start_s", sea::seconds_from_us(change.pace->sea_us)},
                              {"pace", change.pace->permille / static_cast<double>(sea::pace_unit)},
                              {"lapsed", change.lapsed}});
        if (!change.pace && wanted)
            listed.push_back(
                {{"change", change.epoch},
                 {"start_s", sea::seconds_from_us(change.start_us)},
                 {"end_s", sea::seconds_from_us(change.end_us)},
                 {"lapsed", change.lapsed},
                 {"differs",
                  change.epoch == 1
                      ? std::vector<std::string>{}
                      : some_differences(scene_before(changes.first(i), change), change.scene)}});
    }
    const nlohmann::ordered_json all{{"changes", listed}};
    return all.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

} // namespace seaway::server
