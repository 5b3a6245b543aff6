// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/transition.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace seaway::sea {

namespace {

/// exp(-i 2 pi turns), turns in 0.64 fixed point.
std::complex<double> turned_back(std::uint64_t turns) {
    const double angle =
        static_cast<double>(static_cast<std::int64_t>(turns)) * (std::numbers::pi / 0x1p63);
    return {std::cos(angle), -std::sin(angle)};
}

std::uint64_t offset_of(const CascadeModes& modes, std::size_t i) {
    return modes.phase_offset_turns.empty() ? 0 : modes.phase_offset_turns[i];
}

/// How far each wave of `to` must be turned back so that its phase at the change is that of `from`.
std::vector<std::uint64_t> continuous_offsets(const CascadeModes& from, const CascadeModes& to,
                                              TimeUs from_time, TimeUs to_time) {
    std::vector<std::uint64_t> offsets(to.rate.size());
    for (std::size_t i = 0; i < offsets.size(); ++i)
        offsets[i] = offset_of(from, i) + phase_turns(from.rate[i], from_time) -
                     phase_turns(to.rate[i], to_time);
    return offsets;
}

/// The amplitudes of `source`, whose own offsets are taken out, with these offsets put in.
std::vector<std::complex<double>> with_offsets(const CascadeModes& source,
                                               const std::vector<std::uint64_t>& offsets) {
    std::vector<std::complex<double>> h0 = source.h0;
    for (std::size_t i = 0; i < h0.size(); ++i)
        if (const std::uint64_t turn = offsets[i] - offset_of(source, i); turn != 0)
            h0[i] *= turned_back(turn);
    return h0;
}

/// Waves that only the old sea has run on at their old frequency while they fade.
void adopt_rates(const CascadeModes& from, CascadeModes& to) {
    for (std::size_t i = 0; i < to.rate.size(); ++i)
        if (to.rate[i] == 0)
            to.rate[i] = from.rate[i];
}

/// An octave of noise stands, at the change, where the old one stood.
void continue_octave(const NoiseOctave& from, TimeUs from_time, TimeUs to_time, NoiseOctave& to) {
    const auto offset = [&](std::uint64_t old_offset, Rate old_rate, Rate rate) {
        return old_offset - phase_turns(old_rate, from_time) + phase_turns(rate, to_time);
    };
    to.offset_x = offset(from.offset_x, from.rate_x, to.rate_x);
    to.offset_y = offset(from.offset_y, from.rate_y, to.rate_y);
}

/// Stylised waves keep their phase as the modes do.
void continue_sines(const CascadeModes& from, CascadeModes& to, TimeUs from_time, TimeUs to_time) {
    for (std::size_t f = 0; f < std::min(from.sines.size(), to.sines.size()); ++f)
        for (std::size_t w = 0; w < std::min(from.sines[f].waves.size(), to.sines[f].waves.size());
             ++w) {
            const SineField::Wave& old_wave = from.sines[f].waves[w];
            SineField::Wave& wave = to.sines[f].waves[w];
            wave.phase_rad = old_wave.phase_rad + phase_rad(wave.rate, to_time) -
                             phase_rad(old_wave.rate, from_time);
        }
    for (std::size_t f = 0; f < std::min(from.sines.size(), to.sines.size()); ++f)
        for (std::size_t o = 0;
             o < std::min(from.sines[f].octaves.size(), to.sines[f].octaves.size()); ++o)
            continue_octave(from.sines[f].octaves[o], from_time, to_time, to.sines[f].octaves[o]);
}

void scale(SineField& field, double share) {
    for (SineField::Wave& wave : field.waves)
        wave.amplitude_m *= share;
    for (NoiseOctave& octave : field.octaves)
        octave.amplitude_m *= share;
}

void blend_sines(const CascadeModes& before, double share, CascadeModes& modes) {
    for (SineField& field : modes.sines)
        scale(field, share);
    for (SineField field : before.sines) {
        scale(field, 1.0 - share);
        modes.sines.push_back(std::move(field));
    }
}

} // namespace

Result<SeaTransition> SeaTransition::create(RealizationPtr from, RealizationPtr to, TimeUs start_us,
                                            TimeUs end_us) {
    SEAWAY_CHECK(from != nullptr && to != nullptr && start_us <= end_us,
                 "a transition leads from a sea to a sea, forward in time");
    bool same_tiles = from->cascades.size() == to->cascades.size();
    for (std::size_t c = 0; same_tiles && c < to->cascades.size(); ++c)
        same_tiles = from->cascades[c].spec.length_m == to->cascades[c].spec.length_m &&
                     from->cascades[c].spec.size == to->cascades[c].spec.size;
    if (!same_tiles)
        return Error{fmt::format("a sea can only glide over to one with the same cascades: lengths "
                                 "and sizes of {} and {} cascades differ",
                                 from->cascades.size(), to->cascades.size())};
    const TimeUs from_time = from->phase_time(start_us);
    const TimeUs to_time = to->phase_time(start_us);
    auto before = std::make_shared<Realization>(*to);
    auto after = std::make_shared<Realization>(*to);
    before->choppiness = from->choppiness;
    for (std::size_t c = 0; c < to->cascades.size(); ++c) {
        const CascadeModes& old_modes = from->cascades[c];
        adopt_rates(old_modes, after->cascades[c]);
        before->cascades[c].rate = after->cascades[c].rate;
        const std::vector<std::uint64_t> offsets =
            continuous_offsets(old_modes, after->cascades[c], from_time, to_time);
        before->cascades[c].h0 = with_offsets(old_modes, offsets);
        before->cascades[c].depth_m = old_modes.depth_m;
        before->cascades[c].sines = old_modes.sines;
        for (SineField& field : before->cascades[c].sines) {
            for (SineField::Wave& wave : field.waves)
                wave.phase_rad += phase_rad(wave.rate, to_time) - phase_rad(wave.rate, from_time);
            for (NoiseOctave& octave : field.octaves)
                continue_octave(NoiseOctave(octave), from_time, to_time, octave);
        }
        after->cascades[c].h0 = with_offsets(to->cascades[c], offsets);
        before->cascades[c].phase_offset_turns = offsets;
        after->cascades[c].phase_offset_turns = offsets;
        continue_sines(old_modes, after->cascades[c], from_time, to_time);
    }
    SeaTransition transition;
    transition.from_ = std::move(from);
    transition.before_ = std::move(before);
    transition.after_ = std::move(after);
    transition.start_us_ = start_us;
    transition.end_us_ = end_us;
    return transition;
}

RealizationPtr SeaTransition::at(TimeUs time_us) const {
    if (time_us < start_us_)
        return from_;
    if (time_us >= end_us_)
        return after_;
    const double x =
        static_cast<double>(time_us - start_us_) / static_cast<double>(end_us_ - start_us_);
    const double share =
        x * x * x * (10.0 + x * (-15.0 + 6.0 * x)); // no jump in slope or curvature
    auto sea = std::make_shared<Realization>(*after_);
    const auto mix = [share](double a, double b) { return a + share * (b - a); };
    sea->choppiness = {mix(before_->choppiness.x, after_->choppiness.x),
                       mix(before_->choppiness.y, after_->choppiness.y)};
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        std::vector<std::complex<double>>& h0 = sea->cascades[c].h0;
        const std::vector<std::complex<double>>& old_h0 = before_->cascades[c].h0;
        for (std::size_t i = 0; i < h0.size(); ++i)
            h0[i] = old_h0[i] + share * (h0[i] - old_h0[i]);
        // By its inverse: deep water is none, and coth(kd) moves without a jump.
        sea->cascades[c].depth_m =
            1.0 / mix(1.0 / before_->cascades[c].depth_m, 1.0 / after_->cascades[c].depth_m);
        blend_sines(before_->cascades[c], share, sea->cascades[c]);
    }
    return sea;
}

} // namespace seaway::sea
