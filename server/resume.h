// SPDX-License-Identifier: Apache-2.0
// Where a server's sea comes from: the scene it was given, and the journal that may hold it already.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "base/result.h"
#include "server/journal/open_journal.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

struct Resumed {
    std::unique_ptr<Journal> journal; ///< null without a place: the sea ends with the process
    std::int64_t epoch_utc_us;        ///< instant of sea time 0
    bool begins = true;               ///< nobody had begun it before
    std::uint32_t changes = 1;        ///< that were played, the beginning included
    sea::Paces paces = {};
};

/// Without a journal a sea begins at `now_utc_us`. With one the sea of its journal goes on, which must have begun with this
/// scene: its changes are added to the course, which holds the beginning; a place without a journal gets one. An error
/// is one line: those of open_journal(), that the journal is of another sea, with the first line that differs,
/// and a change that this version cannot play.
///
/// Takes 12 ns for each change and grid point, 30 ns where phases hang on all changes (SeaCourse::find_phases): 2.4 and 5.8 ms a
/// change at three cascades of 256 x 256. What never ran, since another change took over from it before, costs nothing.
/// `comes_on` is called before each change, and the log has a line every ten seconds.
Result<Resumed> begin_or_resume(const JournalPlace& place, SeaCourse& course,
                                std::int64_t now_utc_us,
                                const std::function<void()>& comes_on = {});

/// The scene of a change that the journal of this name holds; files are looked for where those of the beginning are.
Result<sea::Scene> scene_of(const SeaChange& change, const std::string& journal,
                            const sea::Scene& beginning);

} // namespace seaway::server
