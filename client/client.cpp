// SPDX-License-Identifier: Apache-2.0
#include "client/client.h"

#include <algorithm>
#include <condition_variable>
#include <future>
#include <utility>

#include "client/link/failure.h"
#include "client/link/patience.h"
#include "client/wanted.h"
#include "sea/basics/glide.h"

namespace seaway::client {

using sea::Answer;
using sea::QueryPoint;
using sea::TimeUs;

namespace {

/// A later epoch takes over from those that were to begin when it does, or after.
bool is_overtaken(const SeaState& state, std::span<const SeaStatePtr> by) {
    return std::ranges::any_of(by, [&state](const SeaStatePtr& other) {
        return other->epoch > state.epoch && other->start_time_us <= state.start_time_us;
    });
}

/// Between a keyframe and the next of its cascade; 0: its sea is over.
TimeUs interval_of(const sea::Keyframe& keyframe, std::span<const SeaStatePtr> states) {
    const auto found = std::ranges::find(states, keyframe.epoch, &SeaState::epoch);
    const auto cascade = static_cast<std::size_t>(keyframe.cascade);
    return found != states.end() && cascade < (*found)->cascades.size()
               ? (*found)->cascades[cascade].interval_us
               : 0;
}

/// Who samples waits for no spline: those of so many keyframes after a sample are made as they come.
constexpr int splines_ahead_max = 256;

} // namespace

ConnectionEvents Client::connection_events(const JoiningPtr& joining) {
    ConnectionEvents events;
    events.on_sea_state = [this, joining](const SeaStatePtr& state) {
        {
            const std::scoped_lock lock(mutex_);
            if (!joining->joined)
                join(*joining, state);
            joining->told_epoch_max = std::max(joining->told_epoch_max, state->epoch);
            std::erase_if(sea_states_, [&](const SeaStatePtr& held) {
                if (held->epoch == state->epoch && !same_waves(*held, *state))
                    forget_waves(held->epoch);
                return held->epoch == state->epoch;
            });
            sea_states_.push_back(state);
            std::erase_if(sea_states_, [&, all = sea_states_](const SeaStatePtr& held) {
                const bool goes = is_overtaken(*held, all);
                if (goes)
                    forget_waves(held->epoch);
                return goes;
            });
            std::stable_sort(sea_states_.begin(), sea_states_.end(),
                             [](const SeaStatePtr& a, const SeaStatePtr& b) {
                                 return a->start_time_us < b->start_time_us;
                             });
            if (sea_states_.size() > protocol::limits::sea_states_held)
                forget_furthest_state();
            changed_.notify_all(); // keep() may have a change to follow
        }
        if (events_.on_sea_state)
            events_.on_sea_state(state);
    };
    events.on_keyframe = [this](const HeldKeyframePtr& keyframe) { take_keyframe(keyframe); };
    take_waves(events);
    events.on_grant = [this](const Grant& grant) { take_grant(grant); };
    take_times(events, joining);
    events.on_tick = [this, joining] {
        bool adopted = false; // it ticks from the first sea state on, which may be before
        {
            const std::scoped_lock lock(mutex_);
            adopted = joining_ == joining;
        }
        if (adopted)
            say_what_is_held();
    };
    events.on_closed = [this, joining](const Error& reason) {
        bool adopted = false;
        {
            const std::scoped_lock lock(mutex_);
            joining->end = reason;
            adopted = joining_ == joining; // else adopt() sees the end
            changed_.notify_all();
        }
        if (events_.on_closed && !joining->end_told)
            events_.on_closed(told(reason, Failure::lost));
        joining->end_told = true; // whatever there is no memory for from here on
        if (adopted && options_.stays_lost)
            say_status();
    };
    return events;
}

void Client::take_keyframe(const HeldKeyframePtr& keyframe) {
    TimeUs now_us = 0, interval_us = 0;
    double hurry = 1.0;
    {
        const std::scoped_lock lock(mutex_);
        now_us = sea_time_held();
        hurry = paces_.hurry(elapsed_held());
        interval_us = interval_of(keyframe->keyframe(), sea_states_);
    }
    if (splines_ahead_ > 0 && keyframe->can_be_sampled()) {
        --splines_ahead_;
        keyframe->spline();
    }
    ring_.insert_passing(keyframe, now_us, interval_us, hurry);
    surfaces_.follow(ring_);
    {
        const std::scoped_lock lock(mutex_);
        for (Wanted* wanted : wanted_)
            wanted->offer(keyframe);
    }
    if (events_.on_keyframe)
        events_.on_keyframe(keyframe);
}

void Client::take_grant(const Grant& grant) {
    const std::scoped_lock asking(asking_);
    std::unique_lock lock(mutex_);
    if (subscription_.wanted()) {
        grant_ = grant;
        return;
    }
    lock.unlock();
    if (const ConnectionPtr connection = link()) // it was asked for before nothing was wanted
        connection->unsubscribe();
}

void Client::forget_waves(std::uint32_t epoch) {
    rebuilt_.erase(epoch);
    followed_.erase(epoch);
    seen_until_us_.erase(epoch);
    forget_received(epoch);
}

void Client::forget_received(std::uint32_t epoch) {
    received_.erase(epoch);
    arriving_.erase(epoch);
    glides_.forget(epoch);
    maps_of_waves_.forget(epoch);
}

std::optional<Error> Client::end() const {
    const std::scoped_lock lock(mutex_);
    const std::optional<Error>& end = joining_->end;
    return end ? std::optional(told(*end, Failure::lost)) : std::nullopt;
}

std::string Client::closed_reason() const {
    const std::optional<Error> why = end();
    return why ? why->message : std::string();
}

std::optional<Grant> Client::grant() const {
    const std::scoped_lock lock(mutex_);
    return grant_;
}

SeaStatePtr Client::sea_state(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    return sea_state_held(time_us);
}

// At one end, so that none in between takes the times of another.
void Client::forget_furthest_state() {
    const auto away_us = [this](const SeaStatePtr& state) { // nothing may have been heard yet
        return std::abs(static_cast<double>(state->start_time_us) - static_cast<double>(heard_us_));
    };
    const bool last = away_us(sea_states_.back()) > away_us(sea_states_[1]); // which ends the first
    const auto gone = last ? std::prev(sea_states_.end()) : sea_states_.begin();
    forget_waves((*gone)->epoch);
    sea_states_.erase(gone);
}

SeaStatePtr Client::sea_state_held(TimeUs time_us) const {
    SeaStatePtr running = sea_states_.front();
    for (const SeaStatePtr& state : sea_states_)
        if (state->start_time_us <= time_us)
            running = state;
    return running;
}

sea::FieldSet Client::offered(sea::FieldSet fields) const {
    const std::scoped_lock lock(mutex_);
    return fields.without(not_offered_);
}

void Client::note_offer(sea::FieldSet asked, sea::FieldSet granted) {
    const std::scoped_lock lock(mutex_);
    not_offered_ = not_offered_.without(granted) | asked.without(granted);
}

template <class Kind>
auto Client::subscribe_and_keep(Kept<Kind>& kept, const Kind& subscription) {
    const Patience patience(subscription.timeout_s);
    typename Kept<Kind>::Serial serial = 0;
    std::optional<decltype(granted(subscription, std::declval<Result<Reply>>()))> had;
    for (;;) {
        Waiter waiter;
        Kind now = subscription;
        now.timeout_s = patience.left_s();
        ConnectionPtr connection;
        int number = 0;
        {
            const std::scoped_lock asking(asking_);
            std::unique_lock lock(mutex_);
            if (had && kept.is_past(serial)) // who came later has his way
                return *std::move(had);
            connection = connection_;
            number = status_.connections;
            // Kept from here on: the connection may end, and come back, behind the grant.
            serial = kept.ask(subscription);
            lock.unlock();
            ask_for(*connection, now, waiter.handler());
        }
        had = granted(subscription, reply_of(waiter));
        {
            const std::scoped_lock lock(asking_, mutex_);
            if (*had)
                kept.granted(serial, subscription, number);
            else
                kept.failed(serial, subscription, had->error());
        }
        const auto again = *had ? std::nullopt : patience.again(had->error());
        if (!again)
            return *std::move(had);
        rest_until(*again, connection);
    }
}

Result<Grant> Client::subscribe(const protocol::TileWish& wish, int credit, double timeout_s) {
    return subscribe_and_keep(subscription_, Subscription{wish, credit, timeout_s});
}

void Client::unsubscribe() {
    const std::scoped_lock asking(asking_);
    link()->unsubscribe();
    wake();
    const std::scoped_lock lock(mutex_);
    subscription_.end();
    grant_.reset();
}

Result<protocol::SpectrumGrant> Client::subscribe_spectrum(const protocol::SpectrumWish& wish,
                                                           double timeout_s) {
    return subscribe_and_keep(spectrum_subscription_, SpectrumSubscription{wish, timeout_s});
}

void Client::unsubscribe_spectrum() {
    const std::scoped_lock asking(asking_);
    link()->unsubscribe_spectrum();
    wake();
    const std::scoped_lock lock(mutex_);
    spectrum_subscription_.end();
}

void Client::ask_for(Connection& connection, const Subscription& subscription,
                     ReplyHandler handler) {
    connection.subscribe(subscription.wish, subscription.credit, subscription.timeout_s,
                         std::move(handler));
}

void Client::ask_for(Connection& connection, const SpectrumSubscription& subscription,
                     ReplyHandler handler) {
    connection.subscribe_spectrum(subscription.wish, subscription.timeout_s, std::move(handler));
}

Result<Grant> Client::granted(const Subscription& subscription, const Result<Reply>& reply) {
    if (!reply)
        return reply.error();
    note_offer(subscription.wish.fields, reply->grant.fields);
    return reply->grant;
}

Result<protocol::SpectrumGrant> Client::granted(const SpectrumSubscription&,
                                                const Result<Reply>& reply) {
    if (!reply)
        return reply.error();
    std::vector<std::shared_ptr<ReceivedSpectrum>> spectra;
    {
        const std::scoped_lock lock(mutex_);
        for (const auto& [epoch, spectrum] : received_)
            spectra.push_back(spectrum);
    }
    for (const auto& spectrum : spectra) {
        const RebuiltSeaPtr waves = spectrum->sea();
        if (spectrum->state()->glide) // which has no probes
            continue;
        if (const Result<void> same = waves ? agrees(*spectrum->state(), *waves) : Result<void>();
            !same) {
            const std::scoped_lock lock(mutex_);
            received_.erase(spectrum->state()->epoch);
            return same.error();
        }
    }
    return reply->spectrum;
}

Result<LocalSurface> Client::surface(TimeUs time_us) const {
    return of_one_sea(
        [&] { return local_surface(*sea_state(time_us), ring_, time_us, sampled_fields()); });
}

Result<void> Client::sample_into(std::span<const QueryPoint> points, std::span<Answer> answers,
                                 const Sampling& how) const {
    SEAWAY_CHECK(points.size() == answers.size(), "one answer a point");
    for (const QueryPoint& point : points)
        SEAWAY_TRY(check_point(point));
    return of_one_sea([&]() -> Result<void> {
        SEAWAY_TRY(sample_from(ring_, surfaces_, points, answers, how));
        return how.of_now ? add_clock(points, answers, how) : Result<void>();
    });
}

Result<std::vector<Answer>> Client::sample(std::span<const QueryPoint> points) const {
    std::vector<Answer> answers(points.size());
    SEAWAY_TRY(sample_into(points, answers));
    return answers;
}

Client::SeaThen Client::sea_then(TimeUs time_us) const {
    const std::scoped_lock lock(mutex_);
    SeaThen then{sea_state_held(time_us), {}, nullptr, {}, {}};
    then.known = known_held(*then.state);
    for (const SeaStatePtr& state : sea_states_) { // by their beginning
        if (state->start_time_us > time_us) {
            then.span.until_us = state->start_time_us;
            break;
        }
        then.span.from_us = state->start_time_us;
    }
    then.waves_of = waves_held(then.state);
    return then;
}

Result<bool> Client::hold_then(SeaThen& then, const KeyframeRing& ring, TimeUs time_us,
                               HeldSurfaces& surfaces, HeldSurfaces::Lent& surface,
                               const Sampling& how) const {
    const auto is_held = [&]() -> Result<void> {
        const std::uint32_t cascades = felt_cascades(*then.state, how.looking);
        if (cascades == 0) // it lies flat
            return check_cascades(*then.state, how.looking);
        if (!how.keyframes_first)
            then.waves = own_sea(then.waves_of);
        if (then.waves)
            return {};
        splines_ahead_ = splines_ahead_max;
        Result<void> lent =
            surfaces.lend(then.state, ring, time_us, sampled_fields(), surface, cascades);
        if (how.keyframes_first && !(lent && surface->covers))
            then.waves =
                own_sea(then.waves_of); // which takes its time where the sea has just changed
        return then.waves ? Result<void>() : lent;
    };
    const Result<void> held = is_held();
    // No longer than the shortest change takes: after that it is another sea.
    if (held || time_us - then.state->start_time_us >= sea::glide_us_min)
        return held ? Result<bool>(false) : held.error();
    const std::uint32_t epoch = then.state->epoch;
    then = sea_then(then.state->start_time_us - 1);
    if (then.state->epoch == epoch || !is_held())
        return held.error();
    return true;
}

Result<void> Client::sample_from(const KeyframeRing& ring, HeldSurfaces& surfaces,
                                 std::span<const QueryPoint> points, std::span<Answer> answers,
                                 const Sampling& how) const {
    HeldSurfaces::Lent surface;
    for (std::size_t first = 0; first < points.size();) {
        const TimeUs time_us = points[first].time_us;
        SeaThen then = sea_then(time_us);
        TimeSpan span = then.span;
        SEAWAY_TRY_LET(const bool late, hold_then(then, ring, time_us, surfaces, surface, how));
        const bool flat = felt_cascades(*then.state, how.looking) == 0;
        if (late || (then.waves && how.keyframes_first)) // others may be covered
            span = {time_us, time_us};
        if (!then.waves && !flat)
            span = glides_choppiness(*then.state) ? TimeSpan{time_us, time_us}
                                                  : span.within(surface.times());
        // All that follows of the same keyframes, at once: points share what a time costs, and wait for memory together.
        std::size_t end = first + 1;
        while (end < points.size() &&
               (points[end].time_us == time_us || span.contains(points[end].time_us)))
            ++end;
        const std::span<const QueryPoint> asked = points.subspan(first, end - first);
        const std::span<Answer> answered = answers.subspan(first, end - first);
        const Sampling some = how.of(first, end - first);
        first = end;
        if (flat)
            lie_flat(asked, answered, some.terms);
        else if (then.waves)
            answer_from_waves(then, asked, answered, some);
        else
            surface->surface.answer(asked, answered, some.answering(surfaces.mixed()));
        const bool beyond = !flat && !then.waves && !surface->covers;
        for (std::size_t i = 0; i < asked.size(); ++i)
            if (beyond || late || !then.known.has(asked[i].time_us))
                answered[i].flags |= sea::answer_extrapolated;
    }
    mark_stale(points, answers, how.terms);
    return {};
}

} // namespace seaway::client
