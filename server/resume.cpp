// SPDX-License-Identifier: Apache-2.0
#include "server/resume.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "server/following.h"
#include "server/journal/sea_clock.h"
#include "server/scene_difference.h"

namespace seaway::server {
namespace {

constexpr std::chrono::seconds said_every{10};
/// Changes: to find them once more costs one of them.
constexpr std::size_t phases_found_every = 16;

/// What two scenes first differ in, for people.
std::string difference(const std::string& held, const std::string& given) {
    const std::vector<SceneDifference> all = scene_differences(held, given);
    if (all.empty()) // the same values in another order
        return "its text is another";
    const SceneDifference& first = all.front();
    const auto says = [](const std::optional<std::string>& value) {
        return value ? "`" + *value + "`" : "nothing of it";
    };
    return fmt::format("of {} it holds {}, the scene says {}", first.path, says(first.before),
                       says(first.after));
}

/// Scenes are compared as they are read: a version that writes more keys reads the old text as before.
Result<void> check_same_sea(const std::string& path, const SeaChange& first,
                            const sea::Scene& scene) {
    SEAWAY_TRY_LET(const sea::Scene read, scene_of(first, path, scene));
    const std::string before = sea::to_toml(read), now = sea::to_toml(scene);
    if (before == now)
        return {};
    return Error{fmt::format("{} is the journal of another sea than {}: {}. Give the scene that it "
                             "began with, or another place of a journal",
                             path, scene.source, difference(before, now))};
}

/// Of each change: when a later one takes over.
std::vector<sea::TimeUs> taken_over_us(const std::vector<SeaChange>& changes) {
    std::vector<sea::TimeUs> all(changes.size());
    sea::TimeUs until_us = std::numeric_limits<sea::TimeUs>::max();
    for (std::size_t i = changes.size(); i-- > 0;) {
        all[i] = until_us;
        if (changes_the_scene(changes[i]))
            until_us = std::min(until_us, changes[i].start_us);
    }
    return all;
}

Result<void> play(const std::string& path, const SeaChange& change, sea::TimeUs until_us,
                  SeaCourse& course) {
    SEAWAY_TRY_LET(const sea::Scene scene, scene_of(change, path, course.first()->scene));
    const Result<void> added = course.add(scene, change.start_us, change.end_us, until_us);
    if (!added)
        return Error{fmt::format("{}: change {} cannot be played: {}", path, change.epoch,
                                 added.error().message)};
    return {};
}

Result<sea::Paces> play_all(const std::string& path, const std::vector<SeaChange>& changes,
                            SeaCourse& course, const std::function<void()>& comes_on) {
    const std::vector<sea::TimeUs> until_us = taken_over_us(changes);
    sea::Paces paces;
    auto said = std::chrono::steady_clock::now();
    for (std::size_t i = 1; i < changes.size(); ++i) {
        if (comes_on)
            comes_on();
        if (const auto now = std::chrono::steady_clock::now(); now - said >= said_every) {
            said = now;
            spdlog::info("event=sea_is_read change={} of={}", changes[i].epoch, changes.size());
        }
        if (changes[i].pace && !changes[i].lapsed)
            paces.add(*changes[i].pace);
        else if (!changes[i].lapsed)
            SEAWAY_TRY(play(path, changes[i], until_us[i], course));
        if (i % phases_found_every == 0) // else all of them are when the sea of now is made
            course.find_phases();
    }
    return paces;
}

/// A clock that is set only later makes a sea of the past until then: who looks at it should know.
void look_at_clock(const Journal& journal, std::int64_t now_utc_us) {
    const std::int64_t made_utc_us = journal.standing().made_utc_us;
    if (now_utc_us < made_utc_us)
        spdlog::warn("event=sea_clock_behind by_s={:.1f} why=\"its last change was made, or its "
                     "sea begun, at {}, and this machine's clock says {}\"",
                     sea::seconds_from_us(made_utc_us - now_utc_us), utc_text(made_utc_us),
                     utc_text(now_utc_us));
}

} // namespace

Result<sea::Scene> scene_of(const SeaChange& change, const std::string& path,
                            const sea::Scene& given) {
    Result<sea::Scene> read = sea::parse_scene(change.scene, path, given.folder);
    if (!read)
        return Error{fmt::format("the sea of change {} in {} cannot be read: {}", change.epoch,
                                 path, read.error().message)};
    read->source = given.source;
    return read;
}

Result<Resumed> begin_or_resume(const JournalPlace& place, SeaCourse& course,
                                std::int64_t now_utc_us, const std::function<void()>& comes_on) {
    if (place.is_none())
        return Resumed{nullptr, now_utc_us};
    const sea::Scene& scene = course.first()->scene;
    SEAWAY_TRY_LET(std::unique_ptr<Journal> journal,
                   open_journal(place, {now_utc_us, sea::to_toml(scene)}));
    SEAWAY_TRY_LET(const std::vector<SeaChange> changes, journal->since(0));
    SEAWAY_TRY(check_same_sea(journal->name(), changes.front(), scene));
    Resumed resumed{nullptr, journal->epoch_utc_us(),
                    changes.size() == 1 && journal->epoch_utc_us() == now_utc_us,
                    static_cast<std::uint32_t>(changes.size())};
    SEAWAY_TRY_LET(resumed.paces, play_all(journal->name(), changes, course, comes_on));
    look_at_clock(*journal, now_utc_us);
    resumed.journal = std::move(journal);
    return resumed;
}

} // namespace seaway::server
