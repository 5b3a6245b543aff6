// SPDX-License-Identifier: Apache-2.0
#include "server/sea_director.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/for_want_of_memory.h"
#include "base/thread_name.h"
#include "base/undo.h"
#include "protocol/limits.h"
#include "sea/scene/weather.h"
#include "server/simulation/schedule.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// Between now and the first keyframe of the new sea, beside what making it is found to take.
constexpr TimeUs spare_us = 1'000'000;
/// A pace is told of this long before it holds, so that all who hear it change over at the same moment.
constexpr TimeUs pace_ahead_us = 1'000'000;
constexpr TimeUs promised_kept_us = 3'600'000'000;
/// And in time, where so much of that is left when it was written.
constexpr TimeUs pace_told_us = 500'000;
/// One that was written too late is followed by another, with more time, so often at most.
constexpr int paces_again_max = 3;
/// Before a change is asked for again that could not be written.
constexpr TimeUs unreachable_pause_us = 1'000'000;
/// How long it sleeps at most: the clock may have leapt; and where it may begin to doubt.
constexpr std::chrono::milliseconds nap{1000}, nap_beside_others{250};

/// Since it began.
class Stopwatch {
  public:
    TimeUs us() const {
        return std::chrono::duration_cast<std::chrono::microseconds>(
                   std::chrono::steady_clock::now() - began_)
            .count();
    }

  private:
    std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

Error refused(Error why) {
    return why.kind == ErrorKind{} ? Error{Refusal::bad_value, std::move(why.message)} : why;
}

/// For so long, by the machine's clock.
Error busy(TimeUs wait_us, const std::string& why) {
    Error error{Refusal::busy,
                fmt::format("{}: ask again in {:.1f} s", why, sea::seconds_from_us(wait_us))};
    error.retry_after_ms = static_cast<std::uint32_t>(
        std::clamp<TimeUs>(wait_us / 1000 + 1, 1, protocol::limits::retry_after_ms_max));
    return error;
}

/// Of all keyframe intervals of both.
std::vector<TimeUs> intervals_of(const RunningSea& a, const RunningSea& b) {
    std::vector<TimeUs> all;
    for (const RunningSea* sea : {&a, &b})
        for (const sea::CascadeBudget& cascade : sea->budget.cascades)
            all.push_back(cascade.interval_us);
    return all;
}

} // namespace

SeaDirector::SeaDirector(std::shared_ptr<SeaCourse> course, Journal* journal, std::uint32_t changes,
                         World& world, SeaClock& clock)
    : course_(std::move(course)), journal_(journal), changes_(changes), world_(world),
      clock_(clock) {
    Undo leave([this] { let_go(); });
    world_.change_by(
        [this](SeaWish wish, Host::Changed done) { change(std::move(wish), std::move(done)); });
    look_at_room();
    if (journal_)
        follow_journal();
    thread_ = std::thread([this] { run(); });
    leave.keep();
}

void SeaDirector::follow_journal() {
    world_.read_by(
        [this](std::uint32_t epoch, std::size_t most) { return journal_->since(epoch, most); });
    journal_->compare_clocks([this] { return clock_.moment().elapsed_us; });
    world_.follow_by([this] { return following(); });
    journal_->call_on_change([this] {
        falls_behind();
        const std::scoped_lock lock(mutex_);
        journal_grew_ = true;
        wake_.notify_one();
    });
}

void SeaDirector::let_go() {
    world_.change_by(nullptr);
    world_.follow_by(nullptr);
    world_.read_by(nullptr);
    if (journal_) {
        journal_->connect_no_more();
        journal_->call_on_change(nullptr);
        journal_->compare_clocks(nullptr);
    }
}

SeaDirector::~SeaDirector() {
    let_go();
    std::deque<Asked> left;
    {
        const std::scoped_lock lock(mutex_);
        stopping_ = true;
        left.swap(asked_);
    }
    wake_.notify_one();
    thread_.join();
    for (const Asked& asked : left)
        asked.done(Error{Refusal::gone, "the server stops"});
}

void SeaDirector::change(SeaWish wish, Host::Changed done) {
    {
        const std::scoped_lock lock(mutex_);
        if (!stopping_ && asked_.size() < changes_waiting_max) {
            asked_.push_back({std::move(wish), std::move(done)});
            wake_.notify_one();
            return;
        }
    }
    done(Error{Refusal::busy, fmt::format("{} changes wait already", changes_waiting_max)});
}

void SeaDirector::run() {
    name_thread("sea-director");
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        journal_grew_ = false;
        lock.unlock();
        look_at_clock();
        follow_if_there_is_memory();
        lock.lock();
        lock.unlock();
        announce(); // also while wishes keep coming
        note_begun();
        lock.lock();
        if (asked_.empty()) {
            wake_.wait_for(lock, journal_ && journal_->spread_us() > 0 ? nap_beside_others : nap,
                           [this] { return stopping_ || journal_grew_ || !asked_.empty(); });
            continue;
        }
        const Asked asked = std::move(asked_.front());
        asked_.pop_front();
        lock.unlock();
        Result<SeaPromise> promise = Error{Refusal::busy, "there is no memory for another sea"};
        try {
            promise = make(asked.wish);
        } catch (const std::bad_alloc&) {
        }
        if (promise)
            announce();
        tell(asked, promise);
        lock.lock();
    }
}

void SeaDirector::look_at_clock() {
    const SeaMoment moment = clock_.moment();
    if (moment.leapt_us == leapt_us_)
        return;
    spdlog::warn("event=sea_clock_leapt by_s={:.1f} to_s={:.1f} why=\"UTC was set forward, or the "
                 "machine slept\"",
                 sea::seconds_from_us(moment.leapt_us - leapt_us_),
                 sea::seconds_from_us(moment.now_us));
    leapt_us_ = moment.leapt_us;
}

void SeaDirector::look_at_room() const {
    if (const std::size_t counted = course_->changes(); counted >= changes_warned_of)
        spdlog::warn(
            "event=sea_log_fills counted={} of={} why=\"a change more than that is refused\"",
            counted, changes_max);
}

TimeUs SeaDirector::spread() const {
    return journal_ ? clock_.hurried(journal_->spread_us()) : 0;
}

/// Who cannot be told will ask again: the change stands in the journal, or it does not.
void SeaDirector::tell(const Asked& asked, const Result<SeaPromise>& promise) {
    if (!tried_for_a_second([&] { asked.done(promise); }))
        spdlog::warn("event=change_not_told why=\"there is no memory for it\"");
}

void SeaDirector::announce() {
    try {
        (void)world_.announce_due();
    } catch (const std::bad_alloc&) {
        spdlog::warn("event=sea_not_announced why=\"there is no memory for it, again in {} s\"",
                     0.001 * static_cast<double>(nap.count()));
    }
}

Result<sea::Scene> SeaDirector::wished(const SeaWish& wish, TimeUs from_us) const {
    sea::Scene running = course_->scene_at(from_us);
    running.folder = sea::no_files; // who changes it is somewhere else
    if (wish.scene.empty())
        return sea::changed(running, wish.set);
    SEAWAY_TRY_LET(sea::Scene scene, sea::parse_scene(wish.scene, "the scene that was sent"));
    scene.source = running.source;
    return scene;
}

TimeUs SeaDirector::first_start(const RunningSea& to) const {
    const TimeUs now_us = clock_.now_us();
    return now_us + std::ranges::max(intervals_of(*course_->at(now_us), to)) +
           clock_.hurried(publish_lead_us);
}

SeaDirector::Start SeaDirector::start_of(const SeaWish& wish, const RunningSea& to,
                                         TimeUs making_us) const {
    const TimeUs ready_us =
        first_start(to) + clock_.hurried(std::max(spare_us, 3 * making_us)) + spread();
    // Not moved to where keyframes meet: of two for one time the later would begin first where they meet elsewhere.
    if (wish.at_us >= ready_us && !passed_.hold(wish.at_us))
        return {wish.at_us, false};
    const TimeUs start_us = std::max(ready_us, passed_.until_us);
    return {next_meeting(start_us, intervals_of(*course_->at(start_us - 1), to)), true};
}

Result<SeaDirector::Planned> SeaDirector::plan(const SeaWish& wish) const {
    const Stopwatch all;
    for (TimeUs from_us = std::max(wish.at_us, clock_.now_us());;) {
        SEAWAY_TRY_LET(sea::Scene scene, wished(wish, from_us));
        sea::Scene made_of =
            scene; // its certificate is that of the sea which runs, or none: no file is read
        made_of.accuracy.certificate = {};
        SEAWAY_TRY_LET(RunningSeaPtr to, make_running_sea(made_of, 0));
        const auto [start_us, soonest] = start_of(wish, *to, all.us());
        SEAWAY_TRY(check_takeovers(start_us));
        const SeaPromise promise{course_->epochs() + 1, start_us, start_us + wish.over_us};
        if (!sea::in_time_range(promise.end_us))
            return Error{"the change would end beyond the times of a sea"};
        const Stopwatch checking;
        SEAWAY_TRY(course_->check(scene, promise.start_us, promise.end_us));
        // Anew, later, where a change that was promised begins before this one, which is then one of that sea; or where
        // there was so much to check, as a timetable, that adding it would take until after the start.
        const bool in_time =
            first_start(*to) + spread() + clock_.hurried(checking.us()) <= start_us;
        SEAWAY_TRY_LET(const sea::Scene then, wished(wish, start_us));
        if (in_time && sea::to_toml(then) == sea::to_toml(scene))
            return Planned{std::move(scene), std::move(to), promise, soonest};
        from_us = start_us;
    }
}

Result<void> SeaDirector::check_certain() const {
    const std::optional<Following> now = world_.following();
    const Doubt doubt = now ? now->kind_of_doubt() : Doubt::none;
    // Another pace is what brings those together of whom one is ahead.
    if (doubt == Doubt::none || doubt == Doubt::ahead)
        return {};
    const std::string why = fmt::format(
        "the sea cannot be changed now, this server is not sure of it ({})", now->doubt());
    if (doubt == Doubt::unheard || doubt == Doubt::behind)
        return busy(unreachable_pause_us, why);
    return Error{Refusal::busy, why + ": ask another server of this sea"};
}

void SeaDirector::is_promised(TimeUs start_us) {
    std::erase_if(promised_, [start_us](TimeUs other_us) { return other_us >= start_us; });
    promised_.push_back(start_us);
}

Result<void> SeaDirector::check_promised(const SeaWish& wish) {
    const TimeUs now_us = clock_.now_us();
    // What has begun may come again where sea time goes back (SeaClock::follow).
    std::erase_if(promised_,
                  [now_us](TimeUs start_us) { return start_us <= now_us - promised_kept_us; });
    std::vector<TimeUs> soon;
    const TimeUs soon_us = now_us + world_.announced_ahead();
    std::ranges::copy_if(promised_, std::back_inserter(soon), [&](TimeUs start_us) {
        const bool taken_over = wish.at_us > now_us && start_us >= wish.at_us;
        return start_us > now_us && start_us < soon_us && !taken_over;
    });
    if (soon.size() < changes_promised_max || wish.at_us >= soon_us)
        return {};
    return busy_until(std::ranges::min(soon),
                      fmt::format("{} changes are promised and have not begun", soon.size()));
}

Result<void> SeaDirector::check_takeovers(TimeUs start_us) const {
    const int glides = course_->glides_in_row(start_us);
    if (glides <= takeovers_max)
        return {};
    const TimeUs end_us = course_->window_at(start_us).end_us;
    return busy_until(end_us,
                      fmt::format("{} changes in a row have taken over from one that had not "
                                  "ended, the last ends at {:.1f} s",
                                  glides - 1, sea::seconds_from_us(end_us)));
}

Error SeaDirector::busy_until(TimeUs sea_us, const std::string& why) const {
    const std::optional<TimeUs> wait_us = clock_.wait_us(sea_us);
    return wait_us ? busy(std::max<TimeUs>(*wait_us, 0), why)
                   : Error{Refusal::busy, why + ": ask again when the sea runs"};
}

Result<std::uint32_t> SeaDirector::log(SeaChange change, const std::function<void()>& effect) {
    change.epoch = changes_ + 1;
    try {
        SEAWAY_TRY(append(change));
        effect();
    } catch (const std::bad_alloc&) {
        if (!journal_)
            throw;
        falls_behind(); // what is in the journal is played as the changes of others are
        return Error{fmt::format("change {} may be in the journal by now, and there is no memory "
                                 "for it: the sea changes once there is, and the history says",
                                 change.epoch)};
    }
    changes_ = change.epoch;
    return journal_ ? change.epoch : 0;
}

Result<void> SeaDirector::append(const SeaChange& change) {
    writing_since_us_ = local_now_us();
    const Undo written([this] { writing_since_us_ = 0; });
    const Result<void> kept = journal_ ? journal_->append(change) : Result<void>();
    if (kept)
        return {};
    if (kept.error().is(JournalError::outrun))
        return busy(0, fmt::format("another server has changed the sea meanwhile ({})",
                                   kept.error().message));
    if (kept.error().is(JournalError::clock_behind))
        return Error{Refusal::busy,
                     fmt::format("the sea cannot be changed now ({})", kept.error().message)};
    if (kept.error().is(JournalError::unreachable) || kept.error().is(JournalError::lapsed))
        return busy(unreachable_pause_us,
                    fmt::format("the sea cannot be changed now ({})", kept.error().message));
    if (kept.error().is(JournalError::unknown))
        return Error{
            fmt::format("the change may have been made, and if so all servers follow it: the "
                        "history says, once the journal answers ({})",
                        kept.error().message)};
    return kept;
}

void SeaDirector::was_late() {
    missed_ = true;
    spdlog::warn("event=sea_changes_late change={} why=\"the journal took long\"", changes_.load());
}

Result<bool> SeaDirector::log_pace(const sea::Pace& pace) {
    bool in_time = false;
    SEAWAY_TRY(log({.scene = {}, .pace = pace}, [&] {
        in_time = clock_.moment().elapsed_us + pace_told_us <= pace.from_us;
        if (in_time)
            follow(pace);
    }));
    return in_time;
}

void SeaDirector::follow(const sea::Pace& pace) {
    clock_.follow(pace);
    world_.announce_pace(pace);
}

Result<SeaPromise> SeaDirector::make_pace(int permille) {
    const TimeUs now_us = clock_.moment().elapsed_us;
    const auto promised = std::ranges::count_if(
        clock_.paces(), [now_us](const sea::Pace& pace) { return pace.from_us > now_us; });
    if (promised >= static_cast<std::ptrdiff_t>(changes_promised_max))
        return busy(pace_ahead_us,
                    fmt::format("{} paces are promised and do not hold yet", promised));
    const TimeUs others_us = journal_ ? journal_->spread_us() : 0;
    sea::Pace pace = clock_.next_pace(now_us + pace_ahead_us + others_us, permille);
    const Stopwatch writing;
    SEAWAY_TRY_LET(bool in_time, log_pace(pace));
    for (int again = 0; !in_time && again < paces_again_max; ++again) {
        // The sea has run on here, and will until another holds, which is one that all can hear of in time. Others that follow
        // the log may have heard of this one.
        const TimeUs from_us =
            clock_.moment().elapsed_us + pace_ahead_us + others_us + writing.us();
        if (others_us > 0) {
            passed_over_since_us_ = local_now_us() - writing.us();
            passed_over_until_us_ = from_us;
        }
        sea::Pace next = clock_.next_pace(from_us, permille);
        if (others_us > 0)
            next.sea_us = std::max(next.sea_us, pace.sea_time(from_us));
        const Result<bool> written = log_pace(next);
        if (!written) {
            passed_over_until_us_ = -sea::time_us_max; // it will follow that one
            break;
        }
        pace = next;
        in_time = *written;
    }
    if (!in_time) {
        follow(pace);
        was_late();
    }
    spdlog::info("event=sea_pace change={} pace={} from_s={}", changes_.load(),
                 permille / static_cast<double>(sea::pace_unit), sea::seconds_from_us(pace.sea_us));
    return SeaPromise{0, pace.sea_us, pace.sea_us, journal_ ? changes_.load() : 0};
}

Result<SeaPromise> SeaDirector::make(const SeaWish& wish) {
    look_at_clock(); // what a change is made after stands before it in the log
    SEAWAY_TRY(check_certain());
    if (wish.pace_permille)
        return make_pace(*wish.pace_permille);
    SEAWAY_TRY(check_promised(wish));
    const Result<Planned> planned = plan(wish);
    if (!planned)
        return refused(planned.error());
    const sea::Scene& scene = planned->scene;
    SeaPromise promise = planned->promise;
    const SeaChange change{
        .start_us = promise.start_us, .end_us = promise.end_us, .scene = sea::to_toml(scene)};
    SEAWAY_TRY_LET(promise.change, log(change, [&] {
                       promised_.reserve(promised_.size() + 1);
                       SEAWAY_CHECK(
                           course_->add(scene, promise.start_us, promise.end_us).has_value(),
                           "what was checked can be added");
                       is_promised(promise.start_us);
                   }));
    spdlog::info("event=sea_changes change={} start_s={} over_s={} hs_m={:.2f}", changes_.load(),
                 sea::seconds_from_us(promise.start_us),
                 sea::seconds_from_us(promise.end_us - promise.start_us),
                 planned->to->summary.realised.significant_height_m);
    look_at_room();
    if (planned->soonest)
        passed_.add(wish.at_us, promise.start_us, clock_.now_us());
    if (clock_.now_us() > promise.start_us)
        was_late();
    return promise;
}

} // namespace seaway::server
