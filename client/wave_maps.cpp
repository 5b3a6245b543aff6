// SPDX-License-Identifier: Apache-2.0
#include "client/wave_maps.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "sea/basics/deviations.h"

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

} // namespace

WaveMaps::WaveMaps(SeaStatePtr state, OwnSeaPtr waves, double (*worked_s)())
    : state_(std::move(state)), waves_(std::move(waves)), worked_s_(worked_s),
      prices_(*state_, *waves_), ring_(two_times()), keyframes_(waves_) {}

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

bool WaveMaps::are_held(TimeUs time_us, std::uint32_t cascades) const {
    return std::ranges::all_of(around(time_us, cascades),
                               [this](const Needed& one) { return held(one) != nullptr; });
}

double WaveMaps::missing_us(TimeUs time_us, std::uint32_t cascades) const {
    double us = 0;
    for (const Needed& one : around(time_us, cascades))
        us += held(one) ? 0 : prices_.keyframe_us(one.cascade);
    return us;
}

bool WaveMaps::is_worth(const WaveBatch& batch) {
    if (!(batch.cascades & 1u) || cannot_be_made_)
        return false;
    return are_held(batch.time_us, batch.cascades) ||
           prices_.pays(cell_span(*state_, batch.time_us), batch,
                        missing_us(batch.time_us, batch.cascades));
}

void WaveMaps::summed(const WaveBatch& batch, double took_us, double laid_out_us) {
    prices_.summed(cell_span(*state_, batch.time_us), batch, took_us, laid_out_us);
}

HeldKeyframePtr WaveMaps::make(const Needed& one) {
    const double begun_s = worked_s_();
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
    HeldKeyframePtr made = HeldKeyframe::as_spline(std::make_shared<const HeldKeyframe>(
        *std::move(keyframe), HeldKeyframe::FieldErrors{}, misses));
    ++made_;
    prices_.made(one.cascade, 1e6 * (worked_s_() - begun_s));
    return made;
}

WaveMaps::Pairs WaveMaps::longest_first(Pairs needed) const {
    std::ranges::sort(needed, std::greater<>{}, [this](const Needed& one) {
        return one.time_us + state_->cascades[static_cast<std::size_t>(one.cascade)].interval_us;
    });
    return needed;
}

bool WaveMaps::make_what_lacks(TimeUs time_us, std::uint32_t cascades, double at_most_us) {
    if (are_held(time_us, cascades)) // another thread has made it
        return true;
    const Pairs needed = longest_first(around(time_us, cascades));
    const Pairs elsewhere = around(used_us_, cascades);
    ring_.keep_only([&](const sea::Keyframe& held) {
        const auto is_it = [&](const Needed& one) {
            return one.cascade == held.cascade && one.time_us == held.time_us;
        };
        return !(cascades >> held.cascade & 1u) || std::ranges::any_of(needed, is_it) ||
               std::ranges::any_of(elsewhere, is_it);
    });
    surfaces_.follow(ring_);
    double takes_us = 0;
    for (const Needed& one : needed)
        if (!held(one)) {
            const double expected_us = prices_.keyframe_us(one.cascade);
            if (takes_us > 0 && takes_us + expected_us > at_most_us)
                break;
            takes_us += expected_us;
            HeldKeyframePtr made = make(one);
            if (!made) {
                cannot_be_made_ = true;
                break;
            }
            ring_.insert(std::move(made));
        }
    surfaces_.follow(ring_);
    prices_.spend(cell_span(*state_, time_us), takes_us);
    return are_held(time_us, cascades);
}

bool WaveMaps::make_for(const WaveBatch& batch) {
    return make_what_lacks(batch.time_us, batch.cascades, 2 * prices_.sum_us(batch));
}

std::unique_lock<std::mutex> WaveMaps::turn_to_make(const WaveBatch& batch) {
    if (prices_.sum_us(batch) > 2 * missing_us(batch.time_us, batch.cascades))
        return std::unique_lock(making_); // who is at it may take as long
    return std::unique_lock(making_, std::try_to_lock);
}

bool WaveMaps::lend(const WaveBatch& batch, HeldSurfaces::Lent& surface) {
    const auto found = [&] {
        return surfaces_.find(state_, ring_, batch.time_us, sea::surface_fields, surface,
                              batch.cascades) &&
               surface->covers;
    };
    const auto lent = [&] {
        return are_held(batch.time_us, batch.cascades) &&
               surfaces_.lend(state_, ring_, batch.time_us, sea::surface_fields, surface,
                              batch.cascades) &&
               surface->covers;
    };
    const auto made = [&] {
        const std::unique_lock making = turn_to_make(batch);
        return making.owns_lock() && make_for(batch) && lent();
    };
    if (!found() && !(is_worth(batch) && (lent() || made())))
        return false;
    answers(batch);
    return true;
}

void WaveMaps::answers(const WaveBatch& batch) {
    prices_.spared(cell_span(*state_, batch.time_us), batch);
    used_us_ = batch.time_us;
}

std::optional<LocalSurface> WaveMaps::held_surface(TimeUs time_us, std::uint32_t cascades) {
    if (!are_held(time_us, cascades))
        return std::nullopt;
    Result<LocalSurface> held =
        local_surface(*state_, ring_, time_us, sea::surface_fields, cascades);
    if (!held || !held->covers)
        return std::nullopt;
    return *std::move(held);
}

std::optional<LocalSurface> WaveMaps::surface(const WaveBatch& batch) {
    if (!is_worth(batch))
        return std::nullopt;
    auto held = held_surface(batch.time_us, batch.cascades);
    if (!held) {
        const std::unique_lock making = turn_to_make(batch);
        if (making.owns_lock() && make_for(batch))
            held = held_surface(batch.time_us, batch.cascades);
    }
    if (held)
        answers(batch);
    return held;
}

std::optional<LocalSurface> WaveMaps::map(TimeUs time_us, int cascade) {
    const std::uint32_t cascades = 1u << cascade;
    auto held = held_surface(time_us, cascades);
    if (!held) {
        const std::scoped_lock making(making_);
        make_what_lacks(time_us, cascades, std::numeric_limits<double>::infinity());
        held = held_surface(time_us, cascades);
    }
    if (held)
        used_us_ = time_us;
    return held;
}

void WaveMaps::let_go() {
    ring_.clear();
    surfaces_.follow(ring_);
}

std::shared_ptr<WaveMaps> MapsOfSeas::of(const SeaStatePtr& state, const OwnSeaPtr& waves) {
    const auto held = [&]() -> std::shared_ptr<WaveMaps> {
        const auto found = std::ranges::find_if(
            seas_, [&](const auto& maps) { return maps->are_of(state, waves); });
        if (found == seas_.end())
            return nullptr;
        std::rotate(found, found + 1, seas_.end());
        if (seas_.size() > with_maps_max)
            seas_[seas_.size() - 1 - with_maps_max]->let_go();
        return seas_.back();
    };
    {
        const std::scoped_lock lock(mutex_);
        if (!seas_.empty() && seas_.back()->are_of(state, waves))
            return seas_.back();
        if (std::shared_ptr<WaveMaps> maps = held())
            return maps;
    }
    auto made = std::make_shared<WaveMaps>(state, waves); // a look at each wave
    const std::scoped_lock lock(mutex_);
    std::erase_if(seas_, [&](const auto& maps) { // whose waves are others now
        return maps->state()->epoch == state->epoch && !maps->are_of(state, waves);
    });
    if (std::shared_ptr<WaveMaps> maps = held())
        return maps;
    if (seas_.size() == seas_max)
        seas_.erase(seas_.begin());
    seas_.push_back(made);
    return held();
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
