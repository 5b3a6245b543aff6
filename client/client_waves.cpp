// SPDX-License-Identifier: Apache-2.0
// Client: whose waves it has, and what sea follows of them.
#include <algorithm>
#include <utility>
#include <vector>

#include "base/elapsed.h"
#include "client/client.h"
#include "client/rebuilt/gliding_sea.h"
#include "client/wave_room.h"
#include "sea/waves/spectrum_builder.h"

namespace seaway::client {

using sea::TimeUs;

std::uint32_t Client::epoch_of_waves_held(const SeaState& steady) const {
    // Its waves are those that the last glide before it led to. One that this took over from may have been meant to end then, too.
    std::uint32_t led_to = steady.epoch;
    for (const SeaStatePtr& other : sea_states_) // in the order in which they begin
        if (other->glide && other->glide->end_us == steady.start_time_us)
            led_to = other->epoch;
    const bool led_to_made = !rebuilt_.contains(steady.epoch) && rebuilt_.contains(led_to);
    return has_waves_held(steady.epoch) && !led_to_made ? steady.epoch : led_to;
}

bool Client::has_waves_held(std::uint32_t epoch) const {
    if (rebuilt_.contains(epoch))
        return true;
    const auto found = received_.find(epoch);
    return found != received_.end() && found->second->has_come();
}

namespace {

std::size_t points_of(const SeaState& state) {
    std::size_t points = 0;
    for (const protocol::CascadeInfo& cascade : state.cascades)
        points += static_cast<std::size_t>(cascade.size) * static_cast<std::size_t>(cascade.size);
    return points;
}

/// A glide whose end is reached then: the waves of its epoch are all that counts.
bool has_ended_by(const SeaState& glide, TimeUs time_us) {
    return glide.glide && glide.glide->end_us <= time_us;
}

} // namespace

void Client::make_room_for_waves(const SeaState& next) {
    std::vector<WavesHeld> held;
    for (const auto& [epoch, spectrum] : received_)
        held.push_back(
            {epoch, points_of(*spectrum->state()), away_us(sea_states_, heard_us_, epoch)});
    std::size_t beside = points_of(next);
    for (const auto& [epoch, spectrum] : arriving_) {
        const auto with = std::ranges::find(held, epoch, &WavesHeld::epoch);
        (with == held.end() ? beside : with->points) += points_of(*spectrum->state());
    }
    for (const std::uint32_t epoch : waves_to_let_go(std::move(held), beside))
        forget_received(epoch);
}

void Client::take_waves(ConnectionEvents& events) {
    events.on_spectrum = [this](const SeaStatePtr& state, const protocol::SpectrumHead& head) {
        {
            const std::scoped_lock lock(mutex_);
            make_room_for_waves(*state);
        }
        const auto begun = std::make_shared<ReceivedSpectrum>(state, head);
        const std::scoped_lock lock(mutex_);
        std::erase_if(received_, [&](const auto& held) { // of seas that are over
            return std::ranges::none_of(
                sea_states_, [&](const SeaStatePtr& known) { return known->epoch == held.first; });
        });
        // Of a sea whose waves are held they would begin with the coarsest.
        (received_.contains(state->epoch) ? arriving_ : received_)[state->epoch] = begun;
    };
    events.on_waves = [this](std::uint32_t epoch, const sea::SpectrumLeft& left,
                             std::span<const sea::WaveBlock> blocks) -> Result<void> {
        const auto held = [&](const auto& spectra) {
            const std::scoped_lock lock(mutex_);
            const auto found = spectra.find(epoch);
            return found == spectra.end() ? nullptr : found->second;
        };
        const auto arriving = held(arriving_), received = held(received_);
        const auto& spectrum = arriving ? arriving : received;
        if (!spectrum)
            return {}; // its sea is over
        SEAWAY_TRY(spectrum->add(left, blocks));
        if (!arriving || (received && arriving->left_m() > received->left_m()))
            return {};
        const std::scoped_lock lock(mutex_);
        received_[epoch] = arriving;
        arriving_.erase(epoch);
        return {};
    };
}

bool Client::holds_waves_held(const SeaStatePtr& state, int depth) const {
    if (!state->glide)
        return has_waves_held(epoch_of_waves_held(*state));
    const SeaStatePtr before = sea_state_held(state->start_time_us - 1);
    if (!has_waves_held(state->epoch) || depth == 0 || before == state)
        return false;
    return has_ended_by(*before, state->start_time_us) ? has_waves_held(before->epoch)
                                                       : holds_waves_held(before, depth - 1);
}

WavesOf Client::waves_of_epoch_held(const SeaStatePtr& state, std::uint32_t epoch) const {
    WavesOf of{.state = state};
    if (const auto made = rebuilt_.find(epoch); made != rebuilt_.end())
        of.made = made->second;
    else if (const auto come = received_.find(epoch); come != received_.end())
        of.received = come->second;
    return of;
}

WavesOf Client::waves_held(const SeaStatePtr& state, int depth) const {
    if (!state->glide)
        return waves_of_epoch_held(state, epoch_of_waves_held(*state));
    WavesOf of = waves_of_epoch_held(state, state->epoch);
    WavesOf before = of ? waves_before_held(state, depth) : WavesOf{};
    if (!before)
        return {};
    of.before = std::make_unique<WavesOf>(std::move(before));
    return of;
}

WavesOf Client::waves_before_held(const SeaStatePtr& glide, int depth) const {
    const SeaStatePtr before = sea_state_held(glide->start_time_us - 1);
    if (depth == 0 || before == glide)
        return {};
    if (!has_ended_by(*before, glide->start_time_us))
        return waves_held(before, depth - 1);
    WavesOf of = waves_of_epoch_held(before, before->epoch); // the sea that it led to
    of.steady = true;
    return of;
}

OwnSeaPtr Client::own_sea(const SeaStatePtr& state) const {
    WavesOf of;
    {
        const std::scoped_lock lock(mutex_);
        of = waves_held(state);
    }
    return own_sea(of);
}

OwnSeaPtr Client::own_sea(const WavesOf& of) const {
    if (!of)
        return nullptr;
    if (of.steady || !of.state->glide)
        return of.end();
    const GlideEnds ends = of.ends();
    if (ends.empty())
        return nullptr;
    const auto held = [&] {
        const std::scoped_lock lock(mutex_);
        return glides_.find(of.state->epoch, ends);
    };
    if (OwnSeaPtr sea = held())
        return sea;
    const OwnSeaPtr from = of.before ? own_sea(*of.before) : nullptr;
    if (!from)
        return nullptr;
    // One at a time, or every thread that samples would make the same one.
    const std::scoped_lock making(making_glides_);
    if (OwnSeaPtr sea = held())
        return sea;
    const TimeUs end_us = of.state->glide->end_us;
    const auto made =
        GlidingSea::create(*of.state, *from, *ends.front(), of.state->start_time_us, end_us,
                           of.made ? GlidingSea::Phases::noted : GlidingSea::Phases::as_sent);
    if (!made)
        return nullptr;
    const std::scoped_lock lock(mutex_);
    if (std::ranges::find(sea_states_, of.state) !=
        sea_states_.end()) // or sent again, or forgotten meanwhile
        glides_.keep(of.state->epoch, end_us, ends, *made);
    return *made;
}

void Client::answer_from_waves(const SeaThen& then, std::span<const sea::QueryPoint> points,
                               std::span<sea::Answer> answers, const Sampling& how) const {
    const std::shared_ptr<WaveMaps> maps =
        how.summed ? nullptr : maps_of_waves_.of(then.state, then.waves);
    const std::uint32_t cascades = felt_cascades(*then.state, how.looking);
    HeldSurfaces::Lent surface;
    for (std::size_t first = 0; first < points.size();) {
        const TimeUs time_us = points[first].time_us;
        const TimeSpan span = !maps                            ? TimeSpan{}
                              : glides_choppiness(*then.state) ? TimeSpan{time_us, time_us + 1}
                                                               : cell_span(*then.state, time_us);
        std::size_t end = first + 1, times = 1;
        for (; end < points.size() && span.contains(points[end].time_us); ++end)
            times += points[end].time_us != points[end - 1].time_us ? 1 : 0;
        const auto asked = points.subspan(first, end - first);
        const auto answered = answers.subspan(first, end - first);
        const Sampling some = how.of(first, end - first);
        first = end;
        const WaveBatch batch{time_us, asked.size(), times, cascades};
        if (maps && maps->lend(batch, surface)) {
            surface->surface.answer(asked, answered, some.answering(maps->mixed()));
            continue;
        }
        const double begun_s = thread_cpu_seconds();
        const double laid_out_s = then.waves->answer(asked, answered, some.terms, cascades);
        if (maps)
            maps->summed(batch, 1e6 * (thread_cpu_seconds() - begun_s), 1e6 * laid_out_s);
        if (how.parts == sea::AnswerParts::height)
            for (sea::Answer& answer : answered)
                leave_out_velocity(answer);
    }
}

} // namespace seaway::client
