// SPDX-License-Identifier: Apache-2.0
#include "server/journal/shared_journal.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <new>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "base/thread_name.h"

namespace seaway::server {

namespace {

/// Of one message: read in two ways, it is rounded in two ways.
bool same_moment(std::int64_t a_us, std::int64_t b_us) {
    return std::abs(a_us - b_us) <= 1;
}

/// The sea that a log begins with never is.
bool is_lapsed(const LoggedChange& logged, const SharedLog::Stored& stored) {
    return logged.change.epoch > 1 && stored.at_utc_us > logged.by_utc_us;
}

} // namespace

SharedJournal::SharedJournal(std::unique_ptr<SharedLog> log, Options options)
    : options_(std::move(options)), log_(std::move(log)), clocks_(options_.writer) {}

SharedJournal::~SharedJournal() {
    connect_no_more();
    {
        const std::scoped_lock lock(stop_mutex_);
        stopping_ = true;
    }
    stop_.notify_all();
    if (thread_.joinable())
        thread_.join();
}

Error SharedJournal::wrong(const std::string& why) const {
    return Error{fmt::format("{}: {}", options_.name, why)};
}

Result<std::unique_ptr<SharedJournal>>
SharedJournal::open(std::unique_ptr<SharedLog> log, const Beginning& beginning, Options options) {
    std::unique_ptr<SharedJournal> journal(new SharedJournal(std::move(log), std::move(options)));
    if (const Result<void> begun = journal->begin(beginning); !begun)
        return journal->refused(begun.error());
    return journal;
}

Result<void> SharedJournal::begin(const Beginning& beginning) {
    SEAWAY_TRY_LET(SharedLog::Tail tail, log_->tail());
    if (tail.last == 0) {
        LoggedChange first{.change = {.scene = beginning.scene},
                           .epoch_utc_us = beginning.epoch_utc_us};
        first.sum = sum_of(first_sum(first.epoch_utc_us), first.change);
        const Result<void> written = write(first);
        if (!written && !written.error().is(LogFailure::outrun))
            return written.error();
    }
    const std::int64_t asked_us = options_.steady();
    SEAWAY_TRY_LET(tail, catch_up());
    if (tail.last == 0) // who leads now has not come to it yet, or it is not one that keeps
        return Error{LogFailure::unanswered, "it does not keep what is written to it"};
    known_us_ = asked_us; // until it listens, whoever leads has settled as well
    heard(asked_us, tail);
    return {};
}

Result<SharedLog::Tail> SharedJournal::catch_up() {
    SEAWAY_TRY_LET(const SharedLog::Tail tail, log_->tail());
    const std::uint64_t held = standing().last_epoch;
    if (!identity_.empty() && tail.identity != identity_)
        return Error{"was removed and made anew; the sea that was followed goes on here until this "
                     "server is started again"};
    if (tail.last < held)
        return Error{
            fmt::format("ends at change {} and held {}: its end was lost", tail.last, held)};
    const Error other_end{fmt::format("has another change {} than was followed: its end was lost "
                                      "and written anew; the sea that was followed goes on here "
                                      "until this server is started again",
                                      held)};
    const bool same_end =
        held == 0 || tail.last > held || same_moment(tail.last_at_utc_us, last_at_utc_us_);
    if (tail.last > held || !same_end) {
        // With the last one that is held, to see that it is the same.
        const std::uint64_t first = std::max<std::uint64_t>(held, 1);
        SEAWAY_TRY_LET(const std::vector<SharedLog::Stored> messages, log_->read(first, tail.last));
        for (std::size_t i = 0; i < messages.size(); ++i)
            if (first + i > held)
                SEAWAY_TRY(hold(messages[i], first + i));
            else if (!is_held(messages[i]))
                return other_end;
    }
    identity_ = tail.identity;
    return tail;
}

/// The last one. Of a cluster that has been joined again a message may have another time at another node; its writer made
/// it once.
bool SharedJournal::is_held(const SharedLog::Stored& stored) const {
    if (same_moment(stored.at_utc_us, last_at_utc_us_))
        return true;
    const Result<LoggedChange> logged = read_message(stored.message);
    const std::scoped_lock lock(mutex_);
    return logged && logged->by_utc_us == last_by_utc_us_ &&
           sum_with_verdict(logged->sum, is_lapsed(*logged, stored)) == sum_;
}

Result<void> SharedJournal::hold(const SharedLog::Stored& stored, std::uint64_t number) {
    const auto named = [number](const std::string& why) {
        return Error{fmt::format("message {} {}; it is left as it is", number, why)};
    };
    Result<LoggedChange> logged = read_message(stored.message);
    if (!logged)
        return named(logged.error().message);
    const std::scoped_lock lock(mutex_);
    const SeaChange last = changes_.empty() ? SeaChange{.epoch = 0, .scene = {}} : changes_.back();
    if (const Result<void> next = check_next(last, logged->change); !next)
        return named("is out of turn: " + next.error().message);
    if (number == 1) {
        if (const Result<void> epoch = check_epoch(logged->epoch_utc_us); !epoch)
            return named(epoch.error().message);
        epoch_utc_us_ = logged->epoch_utc_us;
        sum_ = first_sum(epoch_utc_us_);
    }
    const std::uint64_t sum = sum_of(sum_, logged->change);
    if (sum != logged->sum)
        return named(last.lapsed ? "is damaged, of another sea's log, or was made where the one "
                                   "before has not lapsed as it has here"
                                 : "is damaged, of another sea's log, or was made where the one "
                                   "before has lapsed as it has not here");
    if (number == 1 && (logged->change.start_us != 0 || logged->change.pace))
        return named("is not the sea that a log begins with");
    logged->change.lapsed = is_lapsed(*logged, stored);
    const std::uint64_t with_verdict = sum_with_verdict(sum, logged->change.lapsed);
    changes_.push_back(std::move(logged->change));
    // Once it is held: where there was no memory for it the next look takes it.
    sum_ = with_verdict;
    last_at_utc_us_ = stored.at_utc_us;
    last_by_utc_us_ = logged->by_utc_us;
    return {};
}

Result<bool> SharedJournal::stands_under(const std::string& id, std::uint64_t number) {
    SEAWAY_TRY_LET(const std::vector<SharedLog::Stored> messages, log_->read(number, number));
    return messages.front().id == id;
}

/// Under one id: what was written and not acknowledged is not written twice.
Result<void> SharedJournal::write(const LoggedChange& logged) {
    const std::string message = message_of(logged);
    const std::string id = fmt::format("{}-{}", options_.writer, ++writes_);
    const std::uint64_t before = logged.change.epoch - 1;
    bool may_be_there = false;
    Error last{"was not asked"};
    for (int i = 0; i < writes_max; ++i) {
        const Result<std::uint64_t> number = log_->write(message, id, before);
        if (number && *number == logged.change.epoch)
            return {};
        if (number)
            return Error{fmt::format("took change {} as message {}", logged.change.epoch, *number)};
        last = number.error();
        if (last.is(LogFailure::outrun)) {
            // By another change, or by an attempt of its own whose answer was lost.
            const Result<bool> mine = stands_under(id, logged.change.epoch);
            if (mine)
                return *mine ? Result<void>() : last;
            last = Error{LogFailure::unanswered, mine.error().message};
        }
        may_be_there = may_be_there || last.is(LogFailure::unanswered);
        if (!last.is(LogFailure::unanswered) && !last.is(LogFailure::unreachable))
            return last;
    }
    if (may_be_there)
        last.kind = LogFailure::unanswered;
    return last;
}

void SharedJournal::heard(std::int64_t asked_us, const Result<SharedLog::Tail>& tail) {
    const std::scoped_lock lock(mutex_);
    trouble_ = tail ? "" : tail.error().message;
    const bool sure = tail && tail->unsure_us <= current_us;
    if (sure && (!sure_us_ || asked_us - *sure_us_ > current_us))
        sure_since_us_ = asked_us;
    sure_us_ = sure ? std::optional(asked_us) : std::nullopt;
    // Who leads and has been joined to the others a moment ago may still bring to the log what it was told before: after a silence
    // one answer is not enough.
    const bool was_current = asked_us - known_us_ <= current_us;
    if (tail && (was_current || (sure && asked_us - sure_since_us_ >= settles_us)))
        known_us_ = asked_us - tail->unsure_us;
}

bool SharedJournal::poll() {
    {
        const std::scoped_lock lock(log_mutex_);
        const std::uint32_t before = standing().last_epoch;
        // Of the moment at which it was asked: what was appended while the answer travelled is not in it.
        const std::int64_t asked_us = options_.steady();
        heard(asked_us, catch_up());
        if (standing().last_epoch == before)
            return false;
    }
    const std::scoped_lock lock(call_mutex_);
    if (call_)
        call_();
    return true;
}

void SharedJournal::follow() {
    thread_ = std::thread([this] { run(); });
}

void SharedJournal::run() {
    name_thread("sea-journal");
    std::unique_lock lock(stop_mutex_);
    while (!stopping_) {
        lock.unlock();
        try {
            poll();
        } catch (const std::bad_alloc&) {
            // The next look may find some; until then the log has not been heard of.
        }
        lock.lock();
        stop_.wait_for(lock, std::chrono::microseconds(poll_us), [this] { return stopping_; });
    }
}

Result<std::vector<SeaChange>> SharedJournal::since(std::uint32_t epoch, std::size_t most) const {
    const std::scoped_lock lock(mutex_);
    const std::span<const SeaChange> after =
        std::span(changes_).subspan(std::min<std::size_t>(epoch, changes_.size()));
    const std::span<const SeaChange> some = after.first(std::min(most, after.size()));
    return std::vector<SeaChange>(some.begin(), some.end());
}

/// With the kind that a journal's user knows.
Error SharedJournal::refused(const Error& why) const {
    Error error = wrong(why.message);
    if (why.is(LogFailure::outrun))
        error.kind = JournalError::outrun;
    if (why.is(LogFailure::unreachable))
        error.kind = JournalError::unreachable;
    if (why.is(LogFailure::unanswered)) {
        error.kind = JournalError::unknown;
    }
    return error;
}

/// Where the sea's clock is pulled towards the machine's, which was set forward, and NATS has shown that it agrees with that: all that
/// is made until it is there would lapse as well, and stay in the log.
Result<void> SharedJournal::check_with_utc(std::int64_t behind_us) {
    lapses_ = lapses_ && behind_us > stored_within_us / 2;
    if (!lapses_)
        return {};
    return Error{JournalError::clock_behind,
                 wrong(fmt::format("takes nothing: the sea is {:.1f} s behind UTC since this "
                                   "machine's clock was set; a restart takes it there",
                                   1e-6 * static_cast<double>(behind_us)))
                     .message};
}

Result<void> SharedJournal::append(const SeaChange& change) {
    // Of now, when its start was planned, however long the log keeps it waiting.
    const std::int64_t made_utc_us = utc_us(), by_utc_us = made_utc_us + stored_within_us;
    const std::int64_t behind_us = options_.utc() - made_utc_us;
    const std::int64_t made_us = options_.steady();
    const std::scoped_lock lock(log_mutex_);
    SEAWAY_TRY(check_with_utc(behind_us));
    const std::int64_t began_us = options_.steady();
    // Also so that nothing is written to a log that is not the one that was followed.
    const Result<SharedLog::Tail> end = catch_up();
    if (!end) {
        Error why = end.error();
        if (why.is(LogFailure::unanswered))
            why.kind = LogFailure::unreachable; // it was only asked
        return refused(why);
    }
    // It would keep the change, and bring it to the log when it is joined again, from before that.
    if (end->unsure_us > current_us)
        return refused({LogFailure::unreachable,
                        fmt::format("who orders it has not heard of a majority for {:.1f} s",
                                    1e-6 * static_cast<double>(end->unsure_us))});
    SeaChange last;
    {
        const std::scoped_lock mine(mutex_);
        last = changes_.back();
    }
    if (change.epoch != 0 && change.epoch <= last.epoch)
        return refused(
            {LogFailure::outrun, fmt::format("another change has epoch {} already", change.epoch)});
    if (const Result<void> next = check_next(last, change); !next)
        return wrong(next.error().message);
    if (options_.steady() - made_us > stored_within_us)
        return refused({LogFailure::unreachable, "has not answered in time"});
    const LoggedChange logged{
        .change = change, .by_utc_us = by_utc_us, .sum = sum_of(sum_, change)};
    if (const Result<void> written = write(logged); !written)
        return refused(written.error());
    // As everybody reads it: what is durable, and when it was stored.
    if (const Result<SharedLog::Tail> tail = catch_up(); !tail)
        return refused({LogFailure::unanswered, tail.error().message});
    const std::scoped_lock mine(mutex_);
    if (changes_.size() < change.epoch) // who leads now has not come to it yet
        return refused({LogFailure::unanswered, "took the change and does not show it yet"});
    if (!changes_[change.epoch - 1].lapsed)
        return {};
    const std::string late =
        fmt::format("change {} was stored more than {} s after it was made, by the clock of the "
                    "log: it changes nothing",
                    change.epoch, stored_within_us / 1'000'000);
    if (options_.steady() - began_us > stored_within_us)
        return Error{JournalError::lapsed, wrong(late).message};
    lapses_ = true;
    return Error{
        JournalError::clock_behind,
        wrong(late + ". It was stored at once: this server's clock is behind that of NATS, and one "
                     "of both has to be set right")
            .message};
}

/// Changes begin by the sea's clock. The machine's may have been set since: the sea's goes on, and is that of the other servers.
std::int64_t SharedJournal::utc_us() const {
    const std::scoped_lock lock(mutex_);
    return elapsed_us_ ? epoch_utc_us_ + elapsed_us_() : options_.utc();
}

JournalStanding SharedJournal::standing() const {
    const std::scoped_lock lock(mutex_);
    JournalStanding standing{.last_epoch = static_cast<std::uint32_t>(changes_.size()),
                             .unheard_us = options_.steady() - known_us_,
                             .peers = elapsed_us_ ? clocks_.seen(options_.steady()) : PeersSeen{},
                             .trouble = trouble_};
    standing.current = standing.unheard_us <= current_us;
    standing.compares = elapsed_us_ && standing.peers.judges < 2 &&
                        options_.steady() - comparing_since_us_ < compares_us;
    standing.settles = !standing.current && sure_us_.has_value();
    return standing;
}

void SharedJournal::compare_clocks(std::function<std::int64_t()> elapsed_us) {
    if (!elapsed_us)
        line_.reset(); // its thread calls what there is
    {
        const std::scoped_lock lock(mutex_);
        elapsed_us_ = std::move(elapsed_us);
        comparing_since_us_ = options_.steady();
    }
    // In this order what the sea shows lies within the trip, however long this thread waits for its processor in between.
    if (line_)
        line_->begin(
            [this] {
                const LocalUs local_us = options_.steady();
                return clocks_.word(local_us, elapsed_us_());
            },
            [this](const std::string& word) {
                const std::int64_t sea_us = elapsed_us_();
                clocks_.hear(word, options_.steady(), sea_us);
            });
}

void SharedJournal::call_on_change(std::function<void()> call) {
    const std::scoped_lock lock(call_mutex_);
    call_ = std::move(call);
}

} // namespace seaway::server
