// SPDX-License-Identifier: Apache-2.0
// Client: how it connects, loses its connection and comes back (decision 0045).
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include <fmt/format.h>

#include "base/quiet_thread.h"
#include "base/thread_name.h"
#include "client/again.h"
#include "client/link/failure.h"
#include "client/wanted.h"

namespace seaway::client {

using sea::TimeUs;
using std::chrono::steady_clock;

namespace {

/// Until a client that has no memory for coming back tries again.
constexpr std::chrono::seconds no_memory_pause{1};

/// The sea time up to which a server knew of all changes when it said that.
TimeUs sure_until_us(const sea::Paces& paces, TimeUs elapsed_us, TimeUs unsure_us) {
    const TimeUs moment_us =
        std::clamp(elapsed_us, -sea::time_us_max, sea::time_us_max) - unsure_us;
    if (paces.empty() || moment_us >= paces.all().front().from_us)
        return paces.sea_time(moment_us);
    // Before the first pace that is known others may have held: it was no later than the fastest would have it. None had where it
    // begins at the time that clocks count.
    const sea::Pace& first = paces.all().front();
    if (first.sea_us == first.from_us)
        return moment_us;
    const double before_us = static_cast<double>(sea::pace_permille_max) / sea::pace_unit *
                             static_cast<double>(first.from_us - moment_us);
    return std::llround(std::max(static_cast<double>(first.sea_us) - before_us,
                                 static_cast<double>(-sea::time_us_max)));
}

/// A server that was sure until then tells no more of the pace that was to hold, nor of one that has taken over by now.
bool is_lost(const sea::Paces& held, std::span<const sea::Pace> told, TimeUs sure_us,
             TimeUs now_us) {
    constexpr TimeUs told_within_us = 1'000'000; // after it had looked at its clock
    const auto holds =
        std::ranges::find_if(held.all().rbegin(), held.all().rend(),
                             [&](const sea::Pace& pace) { return pace.from_us <= sure_us; });
    return holds != held.all().rend() && std::ranges::none_of(told, [&](const sea::Pace& pace) {
               return pace.from_us >= holds->from_us && pace.from_us <= now_us + told_within_us;
           });
}

} // namespace

Client::Client(ConnectOptions options, ClientEvents events, RingLimits limits)
    : options_(std::move(options)), events_(std::move(events)), ring_(limits) {}

Client::~Client() {
    {
        const std::scoped_lock lock(mutex_);
        leaving_.request_stop();
        changed_.notify_all();
        if (connection_) // and who waits for its replies goes on
            connection_->close();
    }
    if (keeper_.joinable())
        keeper_.join();
    coming_ = {};
    if (connection_)
        connection_->end(); // as in open_link()
    connection_.reset();    // first to go: its events use everything else
}

Result<std::unique_ptr<Client>> Client::connect(const ConnectOptions& options, ClientEvents events,
                                                RingLimits limits) {
    std::unique_ptr<Client> client(new Client(options, std::move(events), limits));
    if (options.threadless) {
        SEAWAY_TRY_LET(client->readiness_, Readiness::create());
    }
    // Not by way of `client`, which whoever called has before this ends.
    const std::stop_callback given_up(options.stop,
                                      [&leaving = client->leaving_] { leaving.request_stop(); });
    if (const Result<void> opened = client->open_link(); !opened)
        return told(opened.error(), Failure::cannot_connect);
    const QuietThreads quiet;
    try {
        if (!options.stays_lost && !options.threadless)
            client->keeper_ = std::thread([client = client.get()] { client->keep(); });
    } catch (const std::system_error& no_thread) {
        return failed(Failure::cannot_connect, no_thread.what());
    }
    return client;
}

Client::ConnectionPtr Client::link() const {
    const std::scoped_lock lock(mutex_);
    return connection_;
}

Result<void> Client::open_link() {
    const auto joining = std::make_shared<Joining>();
    ConnectOptions options = options_;
    options.stop = leaving_.get_token();
    SEAWAY_TRY_LET(ConnectionPtr opened, Connection::open(options, connection_events(joining)));
    const ConnectionPtr before = adopt(std::move(opened), joining);
    // Not on the thread of its own events, one of which may be the last to hold it.
    if (before)
        before->end();
    return {};
}

Client::ConnectionPtr Client::adopt(ConnectionPtr opened, const JoiningPtr& joining) {
    std::unique_lock lock(mutex_);
    connection_.swap(opened);
    joining_ = joining;
    ++status_.connections;
    const bool ended = joining->end.has_value();
    lock.unlock();
    if (ended && options_.stays_lost) // before there was a status to tell of it
        say_status();
    return opened;
}

void Client::keep() {
    name_thread("sea-keeper");
    std::unique_lock lock(mutex_);
    while (!leaving_.stop_requested()) {
        try {
            const auto next = subscribes_next_held();
            if (!joining_->end && next <= steady_clock::now()) {
                subscribe_again(lock);
            } else if (const SeaStatePtr glide = to_follow_held()) {
                follow(lock, *glide);
            } else if (joining_->end) {
                come_back(lock, *joining_->end);
                if (status_.state == LinkState::stopped)
                    return;
            } else if (next < steady_clock::time_point::max()) {
                changed_.wait_until(lock, next);
            } else {
                changed_.wait(lock);
            }
        } catch (const std::bad_alloc&) { // this thread is ours alone: who would be told?
            if (!lock)
                lock.lock();
            changed_.wait_for(lock, no_memory_pause, [&] { return leaving_.stop_requested(); });
        }
    }
}

void Client::note_wait(const Error& why) {
    resuming_ = true;
    again_.reset(); // what was granted was so on the connection before
    status_.reason = why.message;
    status_.state = why.is(Failure::for_good) ? LinkState::stopped : LinkState::waiting;
    next_attempt_ =
        steady_clock::now() + std::chrono::ceil<steady_clock::duration>(pauses_.next(why));
}

void Client::note_attempt() {
    status_.state = LinkState::connecting;
    ++status_.attempts;
}

void Client::come_back(std::unique_lock<std::mutex>& lock, Error why) {
    const auto say = [&] {
        lock.unlock();
        say_status();
        lock.lock();
    };
    status_.attempts = 0;
    for (;;) {
        note_wait(why);
        const auto next = next_attempt_;
        say();
        if (status_.state == LinkState::stopped)
            return;
        changed_.wait_until(lock, next, [&] { return leaving_.stop_requested(); });
        if (leaving_.stop_requested())
            return;
        note_attempt();
        say();
        lock.unlock();
        const Result<void> opened = open_link();
        lock.lock();
        if (opened)
            return;
        why = opened.error();
    }
}

TimeUs Client::elapsed_held() const {
    const LocalUs local_us = local_now_us();
    return std::llround(clock_.status(local_us).offset_us + static_cast<double>(local_us));
}

void Client::say_status() {
    if (!events_.on_status)
        return;
    const std::scoped_lock lock(saying_);
    const ClientStatus now = status();
    said_ = {now.holds_tiles, now.holds_waves, now.stale_s > 0};
    events_.on_status(now);
}

void Client::say_what_is_held() {
    if (!events_.on_status)
        return;
    const std::scoped_lock lock(saying_);
    const ClientStatus now = status();
    if (std::exchange(said_, {now.holds_tiles, now.holds_waves, now.stale_s > 0}) != said_)
        events_.on_status(now);
}

ClientStatus Client::status() const {
    const LocalUs now_us = local_now_us();
    const sea::FieldSet fields = sampled_fields();
    const std::scoped_lock lock(mutex_);
    ClientStatus status = status_;
    status.seas = seas_;
    if (joining_->end && status.state == LinkState::connected) { // a moment ago, or for ever
        status.state = options_.stays_lost ? LinkState::stopped : LinkState::waiting;
        status.reason = joining_->end->message;
    } else if (status.state == LinkState::waiting) {
        const std::chrono::duration<double> left = next_attempt_ - steady_clock::now();
        status.next_attempt_s = std::max(left.count(), 0.0);
    }
    if (silent(now_us))
        status.stale_s = 1e-6 * static_cast<double>(now_us - heard_at_us_);
    const TimeUs sea_time_us = sea_time_held();
    const SeaStatePtr state = sea_state_held(sea_time_us);
    status.holds_waves = holds_waves_held(state);
    const std::uint32_t counted =
        subscription_.wanted() ? subscription_.wanted()->wish.cascades : sea::all_cascades;
    status.held_from_us = std::numeric_limits<TimeUs>::min();
    status.held_until_us = std::numeric_limits<TimeUs>::max();
    for (std::size_t c = 0; c < state->cascades.size(); ++c) {
        if (!(counted >> c & 1u))
            continue;
        status.holds_tiles = true;
        const auto held = ring_
                              .held(static_cast<int>(c), state->epoch, sea_time_us,
                                    state->cascades[c].interval_us, fields)
                              .value_or(std::pair(0, 0));
        status.held_from_us = std::max(status.held_from_us, held.first);
        status.held_until_us = std::min(status.held_until_us, held.second);
    }
    if (!status.holds_tiles || status.held_from_us >= status.held_until_us) {
        status.holds_tiles = false;
        status.held_from_us = status.held_until_us = 0;
    }
    return status;
}

// ---- is it the same sea? ---------------------------------------------------------------------

std::string Client::why_another(const Joining& joining, const SeaState& state) const {
    const auto found = std::ranges::find(sea_states_, state.epoch, &SeaState::epoch);
    const SeaState& like = found == sea_states_.end() ? *sea_states_.back() : **found;
    if (!same_tiles(like, state))
        return "its cascades are others";
    if (found != sea_states_.end() &&
        (like.start_time_us != state.start_time_us || !same_waves(like, state) ||
         std::abs(like.realised.hs_m - state.realised.hs_m) > 2 * sea::probe_error_m))
        return fmt::format("its waves of epoch {} are others", state.epoch);
    // A journal may have been put back: the first sea that a session is told of is the one that runs, and with it it is told of
    // the pace that holds and those to come.
    for (const Joining::Look& look : joining.looks)
        if (std::string lost = what_is_lost(joining, state.epoch, look); !lost.empty())
            return lost;
    for (const Joining::Look& look : joining.looks) {
        const double round_trip_us = static_cast<double>(look.received_us - look.sent_us);
        const ClockStatus clock = clock_.status(look.received_us);
        const double expected_us = clock.offset_us + static_cast<double>(look.received_us);
        const double off_us =
            static_cast<double>(look.elapsed_us) + 0.5 * round_trip_us - expected_us;
        if (std::abs(off_us) > ClockFilter::step_us + clock.error_us + 0.5 * round_trip_us)
            return fmt::format("its time is {:.3g} s away", 1e-6 * std::abs(off_us));
    }
    return {};
}

void Client::join(Joining& joining, const SeaStatePtr& state) {
    const bool first = sea_states_.empty();
    const std::string another = first ? std::string() : why_another(joining, *state);
    if (!another.empty()) {
        status_.reason = fmt::format("another sea than before: {}", another);
        forget_sea(joining, state);
    } else if (!first) {
        if (std::ranges::find(sea_states_, state->epoch, &SeaState::epoch) == sea_states_.end()) {
            const bool apart =
                heard_us_ > missed_.until_us; // what was missed before is not told of any more
            if (apart)
                told_from_us_ = std::max(told_from_us_, missed_.until_us);
            missed_ = {apart ? heard_us_ : std::min(missed_.from_us, heard_us_),
                       std::max(heard_us_, state->start_time_us), true};
        }
        clock_.begin_anew();
    }
    if (first)
        ++seas_;
    if (first || !another.empty()) // of it nothing is held
        told_from_us_ = state->start_time_us;
    for (const sea::Pace& pace : joining.paces)
        paces_.add(pace);
    for (const Joining::Look& look : joining.looks)
        hear(look, !another.empty());
    show_where_it_is();
    joining.joined = true;
}

std::string Client::what_is_lost(const Joining& joining, std::uint32_t told_epoch_max,
                                 const Joining::Look& look) const {
    if (look.unsure_us >= protocol::limits::unsure_us_max) // or longer: it is not said since when
        return {};
    sea::Paces paces = paces_;
    for (const sea::Pace& pace : joining.paces)
        paces.add(pace);
    const TimeUs sure_us = sure_until_us(paces, look.elapsed_us, look.unsure_us);
    if (std::ranges::any_of(sea_states_, [&](const SeaStatePtr& held) {
            return held->epoch > told_epoch_max && held->start_time_us < sure_us;
        }))
        return "it has an earlier epoch";
    if (is_lost(paces_, joining.paces, look.elapsed_us - look.unsure_us, look.elapsed_us))
        return "it runs at another pace";
    return {};
}

void Client::hear(const Joining::Look& look, bool clock_knows) {
    if (!clock_knows)
        clock_.add(look.sent_us, look.received_us, look.elapsed_us);
    // Who looks rarely takes up late what came long ago: it was no earlier than this.
    heard_at_us_ = look.sent_us - look.unsure_us;
    heard_us_ = std::max(heard_us_, sure_until_us(paces_, look.elapsed_us, look.unsure_us));
    unsure_ = look.unsure_us > 0;
    for (const std::uint32_t ended : glides_.let_go_ended(heard_us_))
        maps_of_waves_.forget(ended);
}

void Client::forget_sea(const Joining& joining, const SeaStatePtr& next) {
    // What takes memory is made first: there is always a sea and a time.
    ClockFilter clock;
    for (const Joining::Look& look : joining.looks)
        clock.add(look.sent_us, look.received_us, look.elapsed_us);
    ++seas_;
    sea_states_.assign(1, next);
    clock_ = std::move(clock);
    rebuilt_.clear();
    followed_.clear();
    received_.clear();
    arriving_.clear();
    glides_.clear();
    maps_of_waves_.clear();
    ring_.clear();
    surfaces_.follow(ring_);
    for (Wanted* wanted : wanted_)
        wanted->forget();
    paces_ = {};
    shown_us_ = heard_us_ = std::numeric_limits<TimeUs>::min();
    missed_ = {};
    seen_until_us_.clear();
    not_offered_ = {};
    grant_.reset();
    times_taken_max_ = std::numeric_limits<std::size_t>::max();
    cascades_apart_ = false;
}

} // namespace seaway::client
