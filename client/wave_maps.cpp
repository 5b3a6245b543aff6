// SPDX-License-Identifier: Apache-2.0
#include "client/wave_maps.h"

#include <algorithm>

#include "sea/surface/map_error.h"

namespace seaway::client {

using sea::TimeUs;

namespace {

/// Of one time, and of another that is asked about in turn with it.
RingLimits two_times() {
    RingLimits limits;
    limits.keyframes_per_cascade = RingLimits::keyframes_per_cascade_min;
    limits.as_splines = true;
    return limits;
}

std::vector<double> waves_of(const sea::Realization& sea) {
    std::vector<double> counts;
    for (const sea::CascadeModes& modes : sea.cascades) {
        counts.push_back(static_cast<double>(
            std::ranges::count_if(modes.h0, [](const auto& h0) { return h0 != 0.0; })));
        for (const sea::SineField& field : modes.sines)
            counts.back() += static_cast<double>(field.waves.size());
    }
    return counts;
}

double points_of(const protocol::CascadeInfo& cascade) {
    return static_cast<double>(cascade.size) * cascade.size;
}

} // namespace

WaveMaps::WaveMaps(SeaStatePtr state, OwnSeaPtr waves)
    : state_(std::move(state)), waves_(std::move(waves)),
      waves_count_(waves_of(waves_->change() ? *waves_->change()->after()
                                             : *waves_->waves_at(state_->start_time_us))),
      ring_(two_times()), keyframes_(waves_) {}

HeldKeyframePtr WaveMaps::held(const Needed& one) const {
    const TimeUs interval_us = state_->cascades[static_cast<std::size_t>(one.cascade)].interval_us;
    const std::optional<KeyframePair> pair =
        ring_.around(one.cascade, state_->epoch, one.time_us, interval_us, sea::surface_fields);
    for (const HeldKeyframePtr& found :
         pair ? std::array{pair->before, pair->after} : std::array<HeldKeyframePtr, 2>{})
        if (found && found->keyframe().time_us == one.time_us)
            return found;
    return nullptr;
}

WaveMaps::Pairs WaveMaps::around(TimeUs time_us, std::uint32_t cascades) const {
    Pairs needed;
    const TimeCell cell = time_cell(*state_, time_us);
    for (std::size_t c = 0; c < cell.size(); ++c)
        if (cascades >> c & 1u)
            for (const TimeUs n : {cell.data()[c], cell.data()[c] + 1})
                needed.push_back({static_cast<int>(c), n * state_->cascades[c].interval_us});
    return needed;
}

double WaveMaps::missing_us(TimeUs time_us, std::uint32_t cascades) const {
    double points = 0;
    for (const Needed& one : around(time_us, cascades))
        if (!held(one))
            points += points_of(state_->cascades[static_cast<std::size_t>(one.cascade)]);
    return points * (waves_->change() ? gliding_map_point_us : map_point_us);
}

WaveMaps::Account& WaveMaps::account_of(const TimeSpan& times) {
    const auto found = std::ranges::find_if(accounts_, [&](const Account& account) {
        return account.times.from_us == times.from_us && account.times.until_us == times.until_us;
    });
    if (found != accounts_.end())
        return *found;
    Account& oldest = *std::ranges::min_element(accounts_, {}, &Account::last_used);
    oldest = {.times = times};
    return oldest;
}

bool WaveMaps::are_worth(TimeUs time_us, std::size_t points, std::size_t times,
                         std::uint32_t cascades) {
    if (cannot_be_made_)
        return false;
    const double cost_us = missing_us(time_us, cascades);
    if (cost_us == 0)
        return true;
    const double time_us_a_wave = waves_->change() ? gliding_wave_time_us : sum_wave_time_us;
    double waves = 0;
    for (std::size_t c = 0; c < waves_count_.size(); ++c)
        waves += cascades >> c & 1u ? waves_count_[c] : 0;
    const std::scoped_lock lock(mutex_);
    Account& account = account_of(cell_span(*state_, time_us));
    account.last_used = ++uses_;
    account.spent_us += waves * (sum_wave_us * static_cast<double>(points) +
                                 time_us_a_wave * static_cast<double>(times));
    if (account.spent_us < cost_us)
        return false;
    account.spent_us = 0;
    return true;
}

HeldKeyframePtr WaveMaps::make(const Needed& one) {
    std::optional<sea::Keyframe> keyframe =
        keyframes_.make(state_->epoch, one.cascade, one.time_us);
    if (!keyframe)
        return nullptr;
    // What the waves are off by is of all of them together: the first cascade has it.
    HeldKeyframe::Compact misses;
    if (one.cascade == 0) {
        const RebuiltError off = waves_->error();
        misses.coarser.cut_m = off.height_m / sea::bound_sigmas;
        misses.coarser.displacement_cut_m = off.displacement_m / sea::bound_sigmas;
        misses.coarser.strain = off.strain;
    }
    ++made_;
    return HeldKeyframe::as_spline(std::make_shared<const HeldKeyframe>(
        *std::move(keyframe), HeldKeyframe::FieldErrors{}, misses));
}

bool WaveMaps::make_what_lacks(TimeUs time_us, std::uint32_t cascades) {
    if (missing_us(time_us, cascades) == 0) // another thread has made it
        return true;
    const Pairs needed = around(time_us, cascades);
    for (const Needed& one : needed)
        if (const HeldKeyframePtr there = held(one)) // the last to go
            ring_.insert(there);
    for (const Needed& one : needed)
        if (!held(one)) {
            HeldKeyframePtr made = make(one);
            if (!made) {
                cannot_be_made_ = true;
                return false;
            }
            ring_.insert(std::move(made));
        }
    surfaces_.follow(ring_);
    return true;
}

bool WaveMaps::lend(TimeUs time_us, std::size_t points, std::size_t times,
                    HeldSurfaces::Lent& surface, std::uint32_t cascades) {
    if (!(cascades & 1u) || !are_worth(time_us, points, times, cascades))
        return false;
    const auto lent = [&] {
        return surfaces_.lend(state_, ring_, time_us, sea::surface_fields, surface, cascades) &&
               surface->covers;
    };
    if (missing_us(time_us, cascades) == 0 && lent())
        return true;
    const std::scoped_lock making(making_); // who makes others takes their places
    return make_what_lacks(time_us, cascades) && lent();
}

std::optional<LocalSurface> WaveMaps::surface(TimeUs time_us, std::size_t points,
                                              std::uint32_t cascades) {
    if (!(cascades & 1u) || !are_worth(time_us, points, 1, cascades))
        return std::nullopt;
    return made_surface(time_us, cascades);
}

std::optional<LocalSurface> WaveMaps::map(TimeUs time_us, int cascade) {
    return made_surface(time_us, 1u << cascade);
}

std::optional<LocalSurface> WaveMaps::made_surface(TimeUs time_us, std::uint32_t cascades) {
    const std::scoped_lock making(making_);
    if (!make_what_lacks(time_us, cascades))
        return std::nullopt;
    Result<LocalSurface> made =
        local_surface(*state_, ring_, time_us, sea::surface_fields, cascades);
    return made ? std::optional(*std::move(made)) : std::nullopt;
}

std::shared_ptr<WaveMaps> MapsOfSeas::of(const SeaStatePtr& state, const OwnSeaPtr& waves) {
    const auto held = [&]() -> std::shared_ptr<WaveMaps> {
        for (const std::shared_ptr<WaveMaps>& maps : seas_)
            if (maps->are_of(state, waves))
                return maps;
        return nullptr;
    };
    {
        const std::scoped_lock lock(mutex_);
        if (std::shared_ptr<WaveMaps> maps = held())
            return maps;
    }
    auto made = std::make_shared<WaveMaps>(state, waves); // a look at each wave
    const std::scoped_lock lock(mutex_);
    if (std::shared_ptr<WaveMaps> maps = held())
        return maps;
    std::erase_if(seas_, [&](const auto& maps) { // whose waves are others now
        return maps->state()->epoch == state->epoch;
    });
    if (seas_.size() == seas_max)
        seas_.erase(seas_.begin());
    seas_.push_back(made);
    return made;
}

void MapsOfSeas::forget(std::uint32_t epoch) {
    const std::scoped_lock lock(mutex_);
    std::erase_if(seas_, [&](const auto& maps) { return maps->state()->epoch == epoch; });
}

void MapsOfSeas::clear() {
    const std::scoped_lock lock(mutex_);
    seas_.clear();
}

} // namespace seaway::client
