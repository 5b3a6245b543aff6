// SPDX-License-Identifier: Apache-2.0
#include "server/following.h"

#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sea/basics/time.h"

namespace seaway::server {

std::string Following::doubt() const {
    if (!shared)
        return {};
    if (!stuck.empty())
        return stuck;
    if (!journal.current)
        return fmt::format("the journal has not been heard of for {:.1f} s{}",
                           sea::seconds_from_us(journal.unheard_us),
                           journal.trouble.empty() ? "" : " (" + journal.trouble + ")");
    if (late || behind_us > behind_us_max)
        return fmt::format("{} of {} changes are played", played, journal.last_epoch);
    return {};
}

std::string Following::json() const {
    const std::string why = doubt();
    const nlohmann::ordered_json all{{"name", name},
                                     {"shared", shared},
                                     {"changes", journal.last_epoch},
                                     {"played", played},
                                     {"unheard_s", sea::seconds_from_us(journal.unheard_us)},
                                     {"stale", !why.empty()},
                                     {"why", why}};
    return all.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string Following::metrics() const {
    if (!shared)
        return {};
    std::string text;
    const auto add = [&](std::string_view row, std::string_view help, double value) {
        text += fmt::format("# HELP seaway_{0} {1}\n# TYPE seaway_{0} gauge\nseaway_{0} {2}\n", row,
                            help, value);
    };
    add("journal_changes", "Changes that the journal is known to hold.", journal.last_epoch);
    add("journal_changes_played", "Changes that are part of the sea.", played);
    add("journal_unheard_seconds", "How long ago it was known that the journal holds no more.",
        sea::seconds_from_us(journal.unheard_us));
    add("sea_stale", "1 while this sea may not be that of the other servers: /v1/state says why.",
        doubt().empty() ? 0 : 1);
    return text;
}

} // namespace seaway::server
