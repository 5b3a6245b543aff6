// SPDX-License-Identifier: Apache-2.0
#include "server/publish/spectrum_store.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "sea/basics/deviations.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/spectrum_builder.h"
#include "server/host/refusal.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;

/// Seas whose spectra are kept: as many as may be sent at once.
constexpr std::size_t epochs_kept = limits::spectra_max;
static_assert(epochs_kept >= finest_spectra_held);
/// What each message has beside its payload.
constexpr std::size_t message_head_bytes = 128;
static_assert(limits::spectrum_bytes_max + limits::spectrum_chunks_max * message_head_bytes <=
              encoded_spectrum_bytes_max);

/// The fields that are sums of waves, or made of such.
constexpr sea::FieldSet wave_fields = sea::linear_fields | sea::FieldSet{sea::Field::jacobian};

std::size_t points_of(const sea::Realization& waves) {
    std::size_t points = 0;
    for (const sea::CascadeModes& cascade : waves.cascades)
        points += cascade.h0.size();
    return points;
}

Result<void> check_offered(const sea::Realization& waves) {
    for (const sea::CascadeModes& cascade : waves.cascades)
        if (!cascade.sines.empty())
            return Error{Refusal::not_offered,
                         "this sea has stylised waves, which are no modes and have no spectrum: "
                         "make it from its scene, or take tiles"};
    const std::size_t points = points_of(waves);
    if (points <= sea::spectrum_modes_max)
        return {};
    return Error{Refusal::not_offered,
                 fmt::format("this sea has tiles of {} points together, a spectrum has {} at most",
                             points, sea::spectrum_modes_max)};
}

/// Waves that were given may be told as tiles, where they meet as chance has it, and be more than a chunk can say is missed
/// where all of them add up.
Result<void> check_told(const sea::SpectrumLeft& all) {
    if (all.height_m <= limits::spectrum_left_m_max &&
        all.displacement_m <= limits::spectrum_left_displacement_m_max &&
        all.slope <= limits::spectrum_left_slope_max)
        return {};
    return Error{Refusal::not_offered,
                 fmt::format("the waves of this sea together are higher ({:.3g} m) or steeper "
                             "({:.3g}) than a spectrum can tell: take tiles",
                             all.height_m, all.slope)};
}

/// The last of the rungs that is as fine as the wish; the first one where none is.
/// Wishes travel as floats: 0.01 is as fine as 0.01.
template <class Bound>
std::size_t rung_for(std::size_t rungs, float wished, const Bound& bound) {
    std::size_t rung = 0;
    for (std::size_t n = 0; n < rungs; ++n)
        if (static_cast<float>(bound(n)) <= wished)
            rung = n;
    return rung;
}

SpectrumRung coarser(const SpectrumRung& rung) {
    return {std::min(rung.height + 1, coarsest_rung.height),
            std::min(rung.slope + 1, coarsest_rung.slope)};
}

/// Each message holds the place of all, since a slow reader may have the last one alone.
EncodedSpectrumPtr in_its_place(const Room::Place& place,
                                std::unique_ptr<EncodedSpectrum> encoded) {
    for (EncodedSpectrum::Message& message : encoded->messages)
        message = with_place(place, std::move(message));
    return encoded;
}

/// Nobody but the store has it.
bool is_idle(const EncodedSpectrumPtr& spectrum) {
    return spectrum != nullptr && spectrum.use_count() == 1 &&
           std::ranges::all_of(spectrum->messages, [](const EncodedSpectrum::Message& message) {
               return message.use_count() == 1;
           });
}

Error no_room() {
    return busy("waves that others have not read yet fill the memory there is for "
                "them, try again later");
}

void say(std::string& why, const std::string& reason) {
    why += (why.empty() ? "" : "; ") + reason;
}

} // namespace

SpectrumStore::Rung SpectrumStore::wished(const SpectrumSource& sea, const SpectrumDemand& wish) {
    const auto height_of = [&](std::size_t n) { return height_rungs[n] * sea.height_error_m; };
    const auto slope_of = [](std::size_t n) { return slope_rungs[n]; };
    Rung rung{wish.error_m == 0.0f ? own_height_rung
                                   : rung_for(height_rungs.size(), wish.error_m, height_of),
              rung_for(slope_rungs.size() - 1, wish.slope_error, slope_of)};
    if (wish.slope_error >= 1.0f) // as good as none
        rung.slope = coarsest_rung.slope;
    return rung;
}

std::map<SpectrumStore::Rung, SpectrumStore::Made>& SpectrumStore::of_sea(std::uint32_t epoch) {
    while (made_.size() > epochs_kept || (made_.size() == epochs_kept && !made_.contains(epoch)))
        made_.erase(made_.begin());
    return made_[epoch];
}

bool SpectrumStore::may_fit(std::size_t bytes) const {
    std::size_t idle = 0;
    for (const auto& [epoch, rungs] : made_)
        for (const auto& [rung, made] : rungs)
            idle += is_idle(made.spectrum) ? made.bytes : 0;
    const std::size_t held = room_->held_bytes();
    const std::size_t read = held - std::min(idle, held);
    return read == 0 || read + bytes <= room_->bytes_max();
}

Room::Place SpectrumStore::take(std::size_t bytes) {
    for (;;) {
        if (Room::Place place = room_->take(bytes))
            return place;
        Made* oldest = nullptr;
        for (auto& [epoch, rungs] : made_)
            for (auto& [rung, made] : rungs)
                if (is_idle(made.spectrum) && (!oldest || made.used < oldest->used))
                    oldest = &made;
        if (!oldest || !may_fit(bytes)) // nothing is let go of in vain
            return nullptr;
        oldest->spectrum = nullptr;
    }
}

Result<SpectrumStore::Made> SpectrumStore::instead_of(std::map<Rung, Made>& rungs,
                                                      const Rung& rung) {
    for (auto at = rungs.rbegin(); at != rungs.rend(); ++at)
        if (auto& [other, made] = *at;
            made.spectrum && other.height <= rung.height && other.slope <= rung.slope) {
            made.used = ++uses_;
            return made;
        }
    return no_room();
}

Result<SpectrumStore::Made> SpectrumStore::find_held(const SpectrumSource& sea, const Rung& rung) {
    const std::scoped_lock lock(mutex_);
    const auto rungs = made_.find(sea.epoch);
    if (rungs == made_.end())
        return no_room();
    const auto at = rungs->second.find(rung);
    if (at == rungs->second.end() || !at->second.known())
        return no_room();
    if (at->second.refused)
        return *at->second.refused;
    at->second.used = ++uses_;
    return at->second;
}

Result<SpectrumStore::Made> SpectrumStore::find_or_make(const SpectrumSource& sea,
                                                        const Rung& rung) {
    if (Result<Made> held = find_held(sea, rung); held || !held.error().is(Refusal::busy))
        return held;
    {
        const std::scoped_lock lock(mutex_);
        std::map<Rung, Made>& rungs = of_sea(sea.epoch);
        const auto before = rungs.find(rung); // so large it was
        if (!may_fit(before == rungs.end() ? 0 : before->second.bytes))
            return instead_of(rungs, rung);
    }
    return make(sea, rung);
}

Result<SpectrumStore::Made> SpectrumStore::make(const SpectrumSource& sea, const Rung& rung) {
    const double slope = slope_rungs[rung.slope];
    const sea::QuantisedSpectrum waves =
        sea::quantise(*sea.waves, {height_rungs[rung.height] * sea.height_error_m, slope});
    if (const Result<void> told = check_told(waves.without); !told) {
        const std::scoped_lock lock(mutex_);
        of_sea(sea.epoch)[rung] = {.refused = told.error()};
        return told.error();
    }
    const sea::SpectrumLeft left = waves.left.empty() ? waves.without : waves.left.back();
    std::unique_ptr<EncodedSpectrum> encoded = encode_spectrum(sea, waves);
    ++made_so_far_;
    const std::scoped_lock lock(mutex_);
    std::map<Rung, Made>& rungs = of_sea(sea.epoch);
    Made& made = rungs[rung];
    made = {.bytes = encoded ? encoded->bytes : 0,
            // No step is so fine that a code is too long: then more is left than was wished.
            .slope_error =
                std::max(std::isfinite(slope) ? slope : 0.0, sea::bound_sigmas * left.slope),
            .used = ++uses_};
    if (!encoded)
        return made;
    const Room::Place place = take(made.bytes);
    if (!place)
        return instead_of(rungs, rung);
    made.spectrum = in_its_place(place, std::move(encoded));
    return made;
}

Result<GrantedSpectrum> SpectrumStore::grant_one(const SpectrumSource& sea,
                                                 const SpectrumDemand& wish, const Find& find) {
    SEAWAY_TRY(check_offered(*sea.waves));
    const auto height_of = [&](std::size_t n) { return height_rungs[n] * sea.height_error_m; };
    GrantedSpectrum granted;
    if (wish.error_m > 0 && static_cast<float>(height_of(0)) > wish.error_m)
        say(granted.why,
            fmt::format("heights within {:g} m are the finest of this sea", height_of(0)));
    if (wish.slope_error > 0 && static_cast<float>(slope_rungs[0]) > wish.slope_error)
        say(granted.why, fmt::format("slopes within {:g} are the finest", slope_rungs[0]));
    const Rung first = wished(sea, wish);
    Rung rung = first;
    SEAWAY_TRY_LET(Made found, find(sea, rung));
    while (!found.spectrum && rung != coarsest_rung) {
        rung = coarser(rung);
        SEAWAY_TRY_LET(found, find(sea, rung));
    }
    if (!found.spectrum)
        return Error{Refusal::not_offered,
                     fmt::format("the spectrum of this sea is more than {} bytes",
                                 limits::spectrum_bytes_max)};
    if (rung != first)
        say(granted.why, fmt::format("finer is more than {} bytes", limits::spectrum_bytes_max));
    granted.error_m = static_cast<float>(height_of(rung.height));
    granted.slope_error = static_cast<float>(found.slope_error);
    granted.fields = wish.fields & wave_fields;
    if (wish.fields.contains(sea::Field::foam))
        say(granted.why, "foam is a history and no sum of waves: subscribe to its tiles");
    granted.spectra = {found.spectrum};
    return granted;
}

Result<GrantedSpectrum> SpectrumStore::grant(std::span<const SpectrumSource> seas,
                                             const SpectrumDemand& wish, const Find& find) {
    SEAWAY_CHECK(!seas.empty(), "there is always a sea");
    SEAWAY_TRY_LET(GrantedSpectrum granted, grant_one(seas.front(), wish, find));
    for (const SpectrumSource& sea : seas.subspan(1, std::min(seas.size(), epochs_kept) - 1)) {
        Result<GrantedSpectrum> other = grant_one(sea, wish, find);
        if (!other && other.error().is(Refusal::busy))
            return other;
        if (!other) {
            say(granted.why, fmt::format("epoch {}: {}", sea.epoch, other.error().message));
            continue;
        }
        granted.error_m = std::max(granted.error_m, other->error_m);
        granted.slope_error = std::max(granted.slope_error, other->slope_error);
        granted.spectra.push_back(other->spectra.front());
    }
    return granted;
}

Result<GrantedSpectrum> SpectrumStore::grant(std::span<const SpectrumSource> seas,
                                             const SpectrumDemand& wish) {
    const std::scoped_lock turn(making_);
    return grant(seas, wish, [this](const SpectrumSource& sea, const Rung& rung) {
        return find_or_make(sea, rung);
    });
}

Result<GrantedSpectrum> SpectrumStore::grant(const SpectrumSource& sea,
                                             const SpectrumDemand& wish) {
    return grant(std::span(&sea, 1), wish);
}

std::optional<GrantedSpectrum> SpectrumStore::held(std::span<const SpectrumSource> seas,
                                                   const SpectrumDemand& wish) {
    Result<GrantedSpectrum> granted =
        grant(seas, wish,
              [this](const SpectrumSource& sea, const Rung& rung) { return find_held(sea, rung); });
    if (!granted) // who makes it says why not
        return std::nullopt;
    return *std::move(granted);
}

std::size_t SpectrumStore::points_to_make(std::span<const SpectrumSource> seas,
                                          const SpectrumDemand& wish) {
    std::size_t points = 0;
    for (const SpectrumSource& sea : seas)
        if (const Result<GrantedSpectrum> one =
                grant_one(sea, wish,
                          [this](const SpectrumSource& source, const Rung& rung) {
                              return find_held(source, rung);
                          });
            !one && one.error().is(Refusal::busy))
            points += points_of(*sea.waves);
    return points;
}

} // namespace seaway::server
