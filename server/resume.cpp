// SPDX-License-Identifier: Apache-2.0
#include "server/resume.h"

#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "server/scene_difference.h"

namespace seaway::server {
namespace {

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

Result<void> play(const std::string& path, const SeaChange& change, SeaCourse& course) {
    SEAWAY_TRY_LET(const sea::Scene scene, scene_of(change, path, course.first()->scene));
    if (const Result<void> added = course.add(scene, change.start_us, change.end_us); !added)
        return Error{fmt::format("{}: change {} cannot be played: {}", path, change.epoch,
                                 added.error().message)};
    return {};
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
                                std::int64_t now_utc_us) {
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
    for (std::size_t i = 1; i < changes.size(); ++i)
        if (changes[i].lapsed)
            continue;
        else if (changes[i].pace)
            resumed.paces.add(*changes[i].pace);
        else
            SEAWAY_TRY(play(journal->name(), changes[i], course));
    resumed.journal = std::move(journal);
    return resumed;
}

} // namespace seaway::server
