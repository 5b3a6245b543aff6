// SPDX-License-Identifier: Apache-2.0
// SeaDirector: how it follows what others append to the journal, and whether its sea is theirs.
#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/messages.h"
#include "server/resume.h"
#include "server/sea_director.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// Sessions that were sent away are not sent away again for a doubt that comes and goes.
constexpr std::int64_t hand_overs_apart_us = 30'000'000;
/// Before a journal that could not be written is told of a sea again.
constexpr std::int64_t note_pause_us = 60'000'000;

} // namespace

void SeaDirector::falls_behind() {
    // Another value each time, if by a microsecond: who follows what was there before does not take this for done.
    std::int64_t since_us = behind_since_us_;
    while (!behind_since_us_.compare_exchange_weak(since_us,
                                                   since_us == 0 ? local_now_us() : since_us + 1))
        continue;
}

void SeaDirector::note_begun() {
    const SeaMoment moment = clock_.moment();
    const EpochWindow window = course_->window_at(moment.now_us);
    if (!journal_ || window.epoch == begun_epoch_ || local_now_us() < note_again_us_)
        return;
    // Of a start it began before; after how long, only a sea says that has always run at pace 1.
    const bool starts = begun_epoch_ == 0;
    const bool known = !starts || moment.now_us == moment.elapsed_us;
    try {
        if (known && window.start_us > 0) {
            const Result<void> noted =
                journal_->note_begun(starts ? window.start_us : moment.elapsed_us);
            if (!noted) {
                spdlog::warn("event=sea_begin_not_noted why={}", in_quotes(noted.error().message));
                note_again_us_ = local_now_us() + note_pause_us;
                return;
            }
        }
        begun_epoch_ = window.epoch;
    } catch (const std::bad_alloc&) { // the next look does
    }
}

void SeaDirector::follow_if_there_is_memory() {
    bool follows = false;
    try {
        follow();
        look_for_doubt();
        follows = true;
    } catch (const std::bad_alloc&) {
        if (follows_)
            spdlog::error("event=sea_follows_later why=\"there is no memory for what the journal "
                          "holds\"");
        falls_behind();
    }
    follows_ = follows;
}

void SeaDirector::follow() {
    if (!journal_)
        return;
    std::int64_t behind_since_us = behind_since_us_; // what comes from here on makes it another
    const Result<std::vector<SeaChange>> more = journal_->since(changes_);
    // Anybody is told that it is stuck. Why it is names hosts and files, which are for the log.
    std::string stuck = more ? "" : "the journal cannot be read", why = stuck;
    if (!more)
        why += ": " + more.error().message;
    for (std::size_t i = 0; more && i < more->size() && stuck.empty(); ++i) {
        const SeaChange& next = (*more)[i];
        if (const Result<void> played = play(next); !played) {
            stuck = fmt::format("change {} of another server cannot be played", next.epoch);
            why = fmt::format("{}: {}", stuck, played.error().message);
        } else {
            changes_ = next.epoch;
        }
    }
    if (stuck.empty())
        behind_since_us_.compare_exchange_strong(behind_since_us, 0);
    const std::scoped_lock lock(mutex_);
    if (!stuck.empty() && stuck != stuck_)
        spdlog::error("event=sea_follows_no_more why={}", in_quotes(why));
    stuck_ = std::move(stuck);
}

Result<void> SeaDirector::play(const SeaChange& change) {
    const TimeUs now_us = clock_.now_us();
    if (change.lapsed) {
        spdlog::warn("event=sea_change_lapsed change={} why=\"it was stored too late\"",
                     change.epoch);
        return {};
    }
    if (change.pace) {
        const bool late = change.pace->from_us < clock_.moment().elapsed_us;
        follow(*change.pace);
        missed_ = missed_ || late;
        spdlog::info("event=sea_pace change={} pace={} from_s={} by=another late={}", change.epoch,
                     change.pace->permille / static_cast<double>(sea::pace_unit),
                     sea::seconds_from_us(change.pace->sea_us), late);
        return {};
    }
    SEAWAY_TRY_LET(const sea::Scene scene,
                   scene_of(change, journal_->name(), course_->first()->scene));
    promised_.reserve(promised_.size() + 1);
    SEAWAY_TRY(course_->add(scene, change.start_us, change.end_us));
    look_at_room();
    is_promised(change.start_us); // those that have begun are taken out when they are counted
    missed_ = missed_ || change.start_us <= now_us;
    spdlog::info("event=sea_changes change={} start_s={} over_s={} by=another late={}",
                 change.epoch, sea::seconds_from_us(change.start_us),
                 sea::seconds_from_us(change.end_us - change.start_us), change.start_us <= now_us);
    return {};
}

void SeaDirector::look_for_doubt() {
    (void)world_.sea_time(); // so that it knows since when it is unsure, also while nobody asks
    const std::optional<Following> now = world_.following();
    if (!now || (!now->shared && !missed_))
        return;
    const std::string why = now->doubt();
    handed_over_for_doubt_ = handed_over_for_doubt_ && !why.empty();
    // A log that comes back comes back to all, and its doubt goes within a second: nobody is sent from one to another for that.
    const bool waits = !why.empty() && !handed_over_for_doubt_ && !now->journal.settles &&
                       now->journal.peers.peers > 0;
    if (!why.empty() && doubt_.empty())
        spdlog::warn("event=sea_stale why={}", in_quotes(why));
    if (why.empty() && !doubt_.empty())
        spdlog::info(
            "event=sea_current change={} why=\"it follows the log, and its clock is right\"",
            now->played);
    doubt_ = why;
    const std::int64_t now_us = local_now_us();
    const bool rests = handed_over_us_ != 0 && now_us - handed_over_us_ < hand_overs_apart_us;
    if (missed_ || (waits && !rests)) {
        handed_over_for_doubt_ = !why.empty();
        handed_over_us_ = now_us;
        constexpr const char* missed = "a change of the sea was missed";
        world_.hand_over(missed_ ? missed : why,
                         missed_ ? missed : in_general(now->kind_of_doubt()));
    }
    missed_ = false;
}

Following SeaDirector::following() const {
    Following now{.name = journal_->name(),
                  .journal = journal_->standing(),
                  .shared = journal_->spread_us() > 0,
                  .played = changes_,
                  .counted = course_->changes(),
                  .stuck = {}};
    const std::int64_t since_us = behind_since_us_;
    const std::int64_t writing_since_us = writing_since_us_;
    now.writing_us = writing_since_us > 0 ? local_now_us() - writing_since_us : 0;
    if (clock_.moment().elapsed_us < passed_over_until_us_)
        now.writing_us = std::max(now.writing_us, local_now_us() - passed_over_since_us_);
    now.behind_us = since_us > 0 ? local_now_us() - since_us : 0;
    now.ahead_us = clock_.moment().ahead_us;
    // Nobody else has a journal that is not shared, and to read it is to wait for a disk.
    if (now.shared && now.played < now.journal.last_epoch)
        if (const auto more = journal_->since(now.played))
            now.late = std::ranges::any_of(*more, [this](const SeaChange& change) {
                return change.pace
                           ? change.pace->from_us < clock_.moment().elapsed_us + behind_us_max
                           : change.start_us < clock_.now_us() + clock_.hurried(behind_us_max);
            });
    const std::scoped_lock lock(mutex_);
    now.stuck = stuck_;
    return now;
}

} // namespace seaway::server
