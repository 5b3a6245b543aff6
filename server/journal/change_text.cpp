// SPDX-License-Identifier: Apache-2.0
#include "server/journal/change_text.h"

#include <charconv>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/hash.h"

namespace seaway::server {
namespace {

constexpr std::string_view pace_word = "pace ";
constexpr std::string_view text_magic = "seaway-journal ";
constexpr int text_version = 1;

/// Takes "WORD NUMBER " or "WORD NUMBER\n" off the front.
template <class Number>
bool take(std::string_view& text, std::string_view word, Number& number, int base = 10) {
    if (!text.starts_with(word) || text.size() <= word.size() || text[word.size()] != ' ')
        return false;
    const char* first = text.data() + word.size() + 1;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(first, end, number, base);
    if (error != std::errc{} || stop == end || (*stop != ' ' && *stop != '\n'))
        return false;
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()) + 1);
    return true;
}

} // namespace

std::string text_of(const SeaChange& change) {
    if (!change.pace)
        return change.scene;
    return fmt::format("{}{} {} {}", pace_word, change.pace->from_us, change.pace->sea_us,
                       change.pace->permille);
}

Result<SeaChange> with_text(SeaChange change, std::string text) {
    if (!text.starts_with(pace_word)) {
        change.scene = std::move(text);
        return change;
    }
    std::istringstream words(text.substr(pace_word.size()));
    sea::Pace pace;
    if (!(words >> pace.from_us >> pace.sea_us >> pace.permille) || !words.eof() ||
        pace.permille < 0 || pace.permille > sea::pace_permille_max)
        return Error{fmt::format("change {} has a pace that cannot be read", change.epoch)};
    change.pace = pace;
    return change;
}

std::uint64_t sum_of(std::uint64_t before, const SeaChange& change) {
    return text_hash(fmt::format("{} {} {} {} {}", before, change.epoch, change.start_us,
                                 change.end_us, text_of(change)));
}

std::uint64_t sum_with_verdict(std::uint64_t sum, bool lapsed) {
    return lapsed ? text_hash(fmt::format("{} lapsed", sum)) : sum;
}

// Half of the times: what has passed since then is one, too.
Result<void> check_epoch(std::int64_t epoch_utc_us) {
    constexpr std::int64_t most_us = sea::time_us_max / 2;
    if (epoch_utc_us < -most_us || epoch_utc_us > most_us)
        return Error{fmt::format("has sea time 0 at {} us of UTC (at most {} us either way)",
                                 epoch_utc_us, most_us)};
    return {};
}

std::uint64_t first_sum(std::int64_t epoch_utc_us) {
    return static_cast<std::uint64_t>(epoch_utc_us);
}

Result<void> check_next(const SeaChange& last, const SeaChange& next) {
    if (next.epoch != last.epoch + 1)
        return Error{fmt::format("the change after epoch {} has epoch {}", last.epoch, next.epoch)};
    const auto [from_us, to_us] = next.pace ? std::pair(next.pace->from_us, next.pace->sea_us)
                                            : std::pair(next.start_us, next.end_us);
    for (const sea::TimeUs time_us : {from_us, to_us})
        if (!sea::in_time_range(time_us))
            return Error{fmt::format("change {} holds {} us, which is no time of a sea (at most "
                                     "{} us either way)",
                                     next.epoch, time_us, sea::time_us_max)};
    if (next.pace)
        return {};
    // The first sea has run for ever; others take some time to come.
    if (next.end_us < next.start_us || (next.end_us == next.start_us && next.epoch > 1))
        return Error{
            fmt::format("change {} runs from {} to {} us", next.epoch, next.start_us, next.end_us)};
    return {};
}

std::string message_of(const LoggedChange& logged) {
    const SeaChange& change = logged.change;
    std::string head = fmt::format("{}{}\nepoch {} start_us {} end_us {} by_utc_us {} sum {:016x}",
                                   text_magic, text_version, change.epoch, change.start_us,
                                   change.end_us, logged.by_utc_us, logged.sum);
    if (change.epoch == 1)
        head += fmt::format(" epoch_utc_us {}", logged.epoch_utc_us);
    return head + '\n' + text_of(change);
}

Result<LoggedChange> read_message(const std::string& message) {
    std::string_view rest = message;
    if (!rest.starts_with(text_magic))
        return Error{"is no change of a sea"};
    int layout = 0;
    if (!take(rest, text_magic.substr(0, text_magic.size() - 1), layout))
        return Error{"is cut off"};
    if (layout != text_version)
        return Error{fmt::format("was written by another version of Seaway (its layout is {}, this "
                                 "one reads {})",
                                 layout, text_version)};
    LoggedChange logged;
    SeaChange& change = logged.change;
    if (!take(rest, "epoch", change.epoch) || !take(rest, "start_us", change.start_us) ||
        !take(rest, "end_us", change.end_us) || !take(rest, "by_utc_us", logged.by_utc_us) ||
        !take(rest, "sum", logged.sum, 16) ||
        (change.epoch == 1 && !take(rest, "epoch_utc_us", logged.epoch_utc_us)))
        return Error{"is damaged"};
    SEAWAY_TRY_LET(change, with_text(std::move(change), std::string(rest)));
    return logged;
}

} // namespace seaway::server
