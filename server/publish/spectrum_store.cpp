// SPDX-License-Identifier: Apache-2.0
#include "server/publish/spectrum_store.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "protocol/limits.h"
#include "protocol/messages.h"
#include "protocol/spectrum_codec.h"
#include "sea/waves/quantised_spectrum.h"
#include "sea/waves/spectrum_builder.h"
#include "server/host/refusal.h"

namespace seaway::server {
namespace {

namespace limits = protocol::limits;

/// What a chunk is filled up to, by the estimate of its blocks: three or four of them are the first 10 KB.
constexpr double chunk_bits = 8.0 * 2200;
/// Seas whose spectra are kept: as many as may be sent at once.
constexpr std::size_t epochs_kept = limits::spectra_max;

/// The fields that are sums of waves, or made of such.
constexpr sea::FieldSet wave_fields = sea::linear_fields | sea::FieldSet{sea::Field::jacobian};

Result<void> check_offered(const sea::Realization& waves) {
    std::size_t points = 0;
    for (const sea::CascadeModes& cascade : waves.cascades) {
        if (!cascade.sines.empty())
            return Error{Refusal::not_offered,
                         "this sea has stylised waves, which are no modes and have no spectrum: "
                         "make it from its scene, or take tiles"};
        points += cascade.h0.size();
    }
    if (points <= sea::spectrum_modes_max)
        return {};
    return Error{Refusal::not_offered,
                 fmt::format("this sea has tiles of {} points together, a spectrum has {} at most",
                             points, sea::spectrum_modes_max)};
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

/// Blocks to messages. Compressed they are about as long as estimated; one that is too long is made two.
class Chunks {
  public:
    Chunks(std::uint32_t epoch, const sea::QuantisedSpectrum& waves)
        : epoch_(epoch), waves_(waves) {
        double bits = 0;
        std::size_t first = 0;
        for (std::size_t b = 0; b < waves.blocks.size(); ++b) {
            bits += waves.bits[b];
            const std::size_t count = b + 1 - first;
            if (bits < chunk_bits && count < limits::spectrum_blocks_max &&
                b + 1 < waves.blocks.size())
                continue;
            add(first, count);
            first = b + 1;
            bits = 0;
        }
    }

    std::vector<EncodedSpectrum::Message> messages;
    std::size_t payload_bytes = 0;

  private:
    void add(std::size_t first, std::size_t count) {
        const protocol::Bytes payload =
            protocol::encode_spectrum(std::span(waves_.blocks).subspan(first, count));
        if (payload.size() > limits::spectrum_chunk_bytes_max) {
            add(first, count / 2);
            return add(first + count / 2, count - count / 2);
        }
        payload_bytes += payload.size();
        messages.push_back(std::make_shared<const protocol::Bytes>(
            protocol::spectrum_chunk(epoch_, static_cast<std::uint32_t>(messages.size()),
                                     waves_.left[first + count - 1], payload)));
    }

    const std::uint32_t epoch_;
    const sea::QuantisedSpectrum& waves_;
};

/// Null: larger than the wire takes.
EncodedSpectrumPtr encode(const SpectrumSource& sea, const sea::QuantisedSpectrum& waves) {
    Chunks chunks(sea.epoch, waves);
    if (chunks.payload_bytes > limits::spectrum_bytes_max ||
        chunks.messages.size() > limits::spectrum_chunks_max)
        return nullptr;
    auto encoded = std::make_shared<EncodedSpectrum>();
    encoded->epoch = sea.epoch;
    encoded->ends_epoch = sea.ends_epoch;
    encoded->whole_by_us = sea.whole_by_us;
    encoded->messages.push_back(std::make_shared<const protocol::Bytes>(
        protocol::spectrum({.epoch = sea.epoch,
                            .chunks = static_cast<std::uint32_t>(chunks.messages.size()),
                            .bytes = static_cast<std::uint32_t>(chunks.payload_bytes),
                            .steps = waves.steps,
                            .dispersion = sea.dispersion,
                            .loop_period_us = sea.waves->loop_period_us})));
    for (EncodedSpectrum::Message& message : chunks.messages)
        encoded->messages.push_back(std::move(message));
    for (const EncodedSpectrum::Message& message : encoded->messages)
        encoded->bytes += message->size();
    return encoded;
}

void say(std::string& why, const std::string& reason) {
    why += (why.empty() ? "" : "; ") + reason;
}

} // namespace

const SpectrumStore::Made& SpectrumStore::made(const SpectrumSource& sea, const Rung& rung) {
    while (made_.size() > epochs_kept ||
           (made_.size() == epochs_kept && !made_.contains(sea.epoch)))
        made_.erase(made_.begin());
    std::map<Rung, Made>& of_sea = made_[sea.epoch];
    if (const auto held = of_sea.find(rung); held != of_sea.end())
        return held->second;
    const sea::QuantisedSpectrum waves = sea::quantise(
        *sea.waves, {height_rungs[rung.height] * sea.height_error_m, slope_rungs[rung.slope]});
    const sea::SpectrumLeft left = waves.left.empty() ? waves.without : waves.left.back();
    const double slope = slope_rungs[rung.slope];
    return of_sea[rung] = {encode(sea, waves),
                           std::isfinite(slope) ? slope : sea::spectrum_sigmas * left.slope};
}

Result<GrantedSpectrum> SpectrumStore::grant(const SpectrumSource& sea,
                                             const SpectrumDemand& wish) {
    SEAWAY_TRY(check_offered(*sea.waves));
    const auto height_of = [&](std::size_t n) { return height_rungs[n] * sea.height_error_m; };
    const auto slope_of = [](std::size_t n) { return slope_rungs[n]; };
    Rung rung{wish.error_m == 0.0f ? own_height_rung
                                   : rung_for(height_rungs.size(), wish.error_m, height_of),
              rung_for(slope_rungs.size() - 1, wish.slope_error, slope_of)};
    const Rung coarsest{height_rungs.size() - 1, slope_rungs.size() - 1};
    if (wish.slope_error >= 1.0f) // as good as none
        rung.slope = coarsest.slope;
    GrantedSpectrum granted;
    if (wish.error_m > 0 && static_cast<float>(height_of(0)) > wish.error_m)
        say(granted.why,
            fmt::format("heights within {:g} m are the finest of this sea", height_of(0)));
    if (wish.slope_error > 0 && static_cast<float>(slope_rungs[0]) > wish.slope_error)
        say(granted.why, fmt::format("slopes within {:g} are the finest", slope_rungs[0]));
    const std::scoped_lock lock(mutex_);
    const Rung wished = rung;
    const Made* found = &made(sea, rung);
    while (!found->spectrum && rung != coarsest) {
        rung = {std::min(rung.height + 1, coarsest.height),
                std::min(rung.slope + 1, coarsest.slope)};
        found = &made(sea, rung);
    }
    if (!found->spectrum)
        return Error{Refusal::not_offered,
                     fmt::format("the spectrum of this sea is more than {} bytes",
                                 limits::spectrum_bytes_max)};
    if (rung != wished)
        say(granted.why, fmt::format("finer is more than {} bytes", limits::spectrum_bytes_max));
    granted.error_m = static_cast<float>(height_of(rung.height));
    granted.slope_error = static_cast<float>(found->slope_error);
    granted.fields = wish.fields & wave_fields;
    if (wish.fields.contains(sea::Field::foam))
        say(granted.why, "foam is a history and no sum of waves: subscribe to its tiles");
    granted.spectra = {found->spectrum};
    return granted;
}

Result<GrantedSpectrum> SpectrumStore::grant(std::span<const SpectrumSource> seas,
                                             const SpectrumDemand& wish) {
    SEAWAY_CHECK(!seas.empty(), "there is always a sea");
    SEAWAY_TRY_LET(GrantedSpectrum granted, grant(seas.front(), wish));
    for (const SpectrumSource& sea : seas.subspan(1, std::min(seas.size(), epochs_kept) - 1)) {
        const Result<GrantedSpectrum> other = grant(sea, wish);
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

} // namespace seaway::server
