// SPDX-License-Identifier: Apache-2.0
// Where a server's sea comes from: the scene it was given, and the journal that may hold it already.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"
#include "sea/scene/scene.h"
#include "server/journal/journal.h"

namespace seaway::server {

struct Resumed {
    std::unique_ptr<Journal> journal; ///< null without a data folder: the sea ends with the process
    std::int64_t epoch_utc_us;        ///< instant of sea time 0
};

/// Without a folder a sea begins at `now_utc_us`. With one the sea of its journal goes on, which must have begun with this
/// scene; a folder without a journal gets one. An error is one line: those of SqliteJournal::open(), and that the
/// journal is of another sea, with the first line that differs.
Result<Resumed> begin_or_resume(const std::string& data_dir, const sea::Scene& scene,
                                std::int64_t now_utc_us);

} // namespace seaway::server
