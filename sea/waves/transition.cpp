// SPDX-License-Identifier: Apache-2.0
#include "sea/waves/transition.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace seaway::sea {

namespace {

/// What waves that are there besides were given by hand.
void add_given(const CascadeModes& more, CascadeModes& modes) {
    if (!more.given.empty() && modes.given.empty())
        modes.given.resize(modes.h0.size());
    for (std::size_t i = 0; i < more.given.size(); ++i)
        modes.given[i] = modes.given[i] || more.given[i];
    modes.placed_from_radpm = std::min(modes.placed_from_radpm, more.placed_from_radpm);
}

/// exp(-i 2 pi turns), turns in 0.64 fixed point.
std::complex<double> turned_back(std::uint64_t turns) {
    const double angle = rad_from_turns(turns);
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
        offsets[i] = from.rate[i] == 0 ? offset_of(to, i) // a wave that the old sea does not have
                                       : offset_of(from, i) + phase_turns(from.rate[i], from_time) -
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

/// How far a wave or a drift has turned at the change, on a clock that turns otherwise from then on.
struct Clocks {
    TimeUs from_time;
    TimeUs to_time;

    std::uint64_t since(Rate from, Rate to) const {
        return phase_turns(from, from_time) - phase_turns(to, to_time);
    }
};

bool same_wave(const SineField::Wave& a, const SineField::Wave& b) {
    return a.kx_radpm == b.kx_radpm && a.ky_radpm == b.ky_radpm;
}
bool same_pattern(const NoiseOctave& a, const NoiseOctave& b) {
    return *a.corners == *b.corners;
}

/// The same noise stands, at the change, where it stood.
void continue_octave(const NoiseOctave& from, const Clocks& clocks, NoiseOctave& to) {
    if (!same_pattern(from, to))
        return;
    to.offset_x = from.offset_x - clocks.since(from.rate_x, to.rate_x);
    to.offset_y = from.offset_y - clocks.since(from.rate_y, to.rate_y);
}

/// A wave of the same vector keeps its phase as modes do; its own phase, as theirs, is the new sea's.
void continue_wave(const SineField::Wave& from, const Clocks& clocks, SineField::Wave& to) {
    if (!same_wave(from, to))
        return;
    to.phase_offset_turns = from.phase_offset_turns + clocks.since(from.rate, to.rate);
}

/// Both fields of the same stylised system. A sea that glides has each twice, as it was and as it will be: the same waves, turned
/// by as much.
template <class Before, class After, class F>
void for_each_pair(Before& before, After& after, const F& f) {
    for (auto& b : before)
        for (auto& a : after)
            if (a.number == b.number)
                f(b, a);
}

void continue_field(const SineField& before, const Clocks& clocks, SineField& after) {
    for (std::size_t w = 0; w < std::min(before.waves.size(), after.waves.size()); ++w)
        continue_wave(before.waves[w], clocks, after.waves[w]);
    for (std::size_t o = 0; o < std::min(before.octaves.size(), after.octaves.size()); ++o)
        continue_octave(before.octaves[o], clocks, after.octaves[o]);
}

void continue_sines(const CascadeModes& from, CascadeModes& to, const Clocks& clocks) {
    for_each_pair(from.sines, to.sines, [&](const SineField& before, SineField& after) {
        continue_field(before, clocks, after);
    });
}

/// Waves and patterns that both have turn, and drift, as those of `like` do.
void adopt_speeds(const SineField& like, SineField& field) {
    for (std::size_t w = 0; w < std::min(like.waves.size(), field.waves.size()); ++w)
        if (same_wave(like.waves[w], field.waves[w])) {
            field.waves[w].rate = like.waves[w].rate;
            field.waves[w].omega_radps = like.waves[w].omega_radps;
        }
    for (std::size_t o = 0; o < std::min(like.octaves.size(), field.octaves.size()); ++o)
        if (const NoiseOctave& octave = like.octaves[o]; same_pattern(octave, field.octaves[o])) {
            field.octaves[o].speed_x_mps = octave.speed_x_mps;
            field.octaves[o].speed_y_mps = octave.speed_y_mps;
            field.octaves[o].rate_x = octave.rate_x;
            field.octaves[o].rate_y = octave.rate_y;
        }
}

/// `source` in full, with the phases that it has at `source_time` at `time` on the clock of `onto`,
/// and its frequencies.
void continue_onto(const CascadeModes& source, TimeUs source_time, TimeUs time,
                   CascadeModes& onto) {
    const std::vector<std::uint64_t> offsets = continuous_offsets(source, onto, source_time, time);
    onto.h0 = with_offsets(source, offsets);
    onto.phase_offset_turns = offsets;
    onto.depth_m = source.depth_m;
    const std::vector<SineField> sines = std::exchange(onto.sines, source.sines);
    for_each_pair(sines, onto.sines,
                  [](const SineField& like, SineField& field) { adopt_speeds(like, field); });
    continue_sines(source, onto, {source_time, time});
}

void blend_sines(const CascadeModes& before, double share, CascadeModes& modes) {
    for (SineField& field : modes.sines)
        field.share *= share;
    for (SineField field : before.sines) {
        field.share *= 1.0 - share;
        modes.sines.push_back(std::move(field));
    }
}

/// Every mode of the lattice but k = 0.
template <class F>
void for_each_lattice_mode(const CascadeSpec& spec, const F& f) {
    std::size_t i = 0;
    for (int iy = 0; iy < spec.size; ++iy)
        for (int ix = 0; ix < spec.size; ++ix, ++i)
            if (i > 0)
                f(spec.wavenumber_step_radpm() *
                      std::hypot(signed_index(ix, spec.size), signed_index(iy, spec.size)),
                  i);
}

/// A copy to write into, with the waves of these cascades alone.
std::shared_ptr<Realization> some_of(const Realization& sea, std::uint32_t cascades) {
    auto some = std::make_shared<Realization>();
    some->choppiness = sea.choppiness;
    some->loop_period_us = sea.loop_period_us;
    for (std::size_t c = 0; c < sea.cascades.size(); ++c) {
        const CascadeModes& modes = sea.cascades[c];
        if (cascades >> c & 1u)
            some->cascades.push_back(modes);
        else
            some->cascades.push_back({.spec = modes.spec,
                                      .band = modes.band,
                                      .carries_spectra = modes.carries_spectra,
                                      .depth_m = modes.depth_m});
    }
    return some;
}

} // namespace

Result<RealizationPtr> continued(const Realization& from, const Realization& to, TimeUs time_us) {
    const auto tile = [](const CascadeModes& modes) {
        return std::pair(modes.spec.length_m, modes.spec.size);
    };
    if (!std::ranges::equal(from.cascades, to.cascades, {}, tile, tile))
        return Error{fmt::format("a sea can only glide over to one with the same cascades: lengths "
                                 "and sizes of {} and {} cascades differ",
                                 from.cascades.size(), to.cascades.size())};
    const TimeUs from_time = from.phase_time(time_us);
    const TimeUs to_time = to.phase_time(time_us);
    auto after = std::make_shared<Realization>(to);
    for (std::size_t c = 0; c < to.cascades.size(); ++c) {
        CascadeModes& modes = after->cascades[c];
        const CascadeModes& old_modes = from.cascades[c];
        adopt_rates(old_modes, modes);
        modes.phase_offset_turns = continuous_offsets(old_modes, modes, from_time, to_time);
        modes.h0 = with_offsets(to.cascades[c], modes.phase_offset_turns);
        continue_sines(old_modes, modes, {from_time, to_time});
    }
    return RealizationPtr(std::move(after));
}

Result<SeaTransition> SeaTransition::create(RealizationPtr from, RealizationPtr to, TimeUs start_us,
                                            TimeUs end_us) {
    SEAWAY_CHECK(from != nullptr && to != nullptr && start_us <= end_us,
                 "a transition leads from a sea to a sea, forward in time");
    SEAWAY_TRY_LET(RealizationPtr after, continued(*from, *to, start_us));
    const TimeUs from_time = from->phase_time(start_us);
    const TimeUs to_time = to->phase_time(start_us);
    // Between start and end the sea is of two, and repeats with the loop of neither: a wave that fades
    // would jump where the loop of the new sea begins anew. Phases are taken at the time itself.
    auto fading = std::make_shared<Realization>(*after);
    auto growing = std::make_shared<Realization>(*after);
    fading->loop_period_us = growing->loop_period_us = 0;
    fading->choppiness = from->choppiness;
    for (std::size_t c = 0; c < to->cascades.size(); ++c) {
        continue_onto(from->cascades[c], from_time, start_us, fading->cascades[c]);
        fading->cascades[c].given = from->cascades[c].given;
        fading->cascades[c].placed_from_radpm = from->cascades[c].placed_from_radpm;
        continue_onto(after->cascades[c], to_time, start_us, growing->cascades[c]);
    }
    SeaTransition transition;
    transition.from_ = std::move(from);
    transition.fading_ = std::move(fading);
    transition.growing_ = std::move(growing);
    transition.after_ = std::move(after);
    transition.start_us_ = start_us;
    transition.end_us_ = end_us;
    return transition;
}

double SeaTransition::longest_radpm(std::size_t cascade) const {
    return std::min(fading_->cascades[cascade].longest_radpm(),
                    growing_->cascades[cascade].longest_radpm());
}

RealizationPtr SeaTransition::at(TimeUs time_us) const {
    if (time_us < start_us_)
        return from_;
    return time_us >= end_us_ ? after_ : gliding(time_us);
}

RealizationPtr SeaTransition::gliding(TimeUs time_us, std::uint32_t cascades) const {
    return with_share(glide_share(time_us, start_us_, end_us_), cascades);
}

RealizationPtr SeaTransition::with_share(double share, std::uint32_t cascades) const {
    std::shared_ptr<Realization> sea = some_of(*growing_, cascades);
    sea->choppiness = {glided(fading_->choppiness.x, growing_->choppiness.x, share),
                       glided(fading_->choppiness.y, growing_->choppiness.y, share)};
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        if (cascades >> c &
            1u) // of clocks, too: what takes over goes on with both seas' stylised waves
            blend_sines(fading_->cascades[c], share, sea->cascades[c]);
        if (!sea->cascades[c].is_there())
            continue;
        std::vector<std::complex<double>>& h0 = sea->cascades[c].h0;
        const std::vector<std::complex<double>>& old_h0 = fading_->cascades[c].h0;
        for (std::size_t i = 0; i < h0.size(); ++i)
            h0[i] = old_h0[i] + share * (h0[i] - old_h0[i]);
        sea->cascades[c].depth_m =
            glided_depth_m(fading_->cascades[c].depth_m, growing_->cascades[c].depth_m, share);
        add_given(fading_->cascades[c], sea->cascades[c]);
    }
    return sea;
}

RealizationPtr SeaTransition::growth(TimeUs time_us, std::uint32_t cascades) const {
    const double share = glide_share(time_us, start_us_, end_us_);
    std::shared_ptr<Realization> sea = some_of(*growing_, cascades);
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        CascadeModes& modes = sea->cascades[c];
        const CascadeModes& old_modes = fading_->cascades[c];
        if (!modes.is_there())
            continue;
        for (std::size_t i = 0; i < modes.h0.size(); ++i)
            modes.h0[i] -= old_modes.h0[i];
        add_given(old_modes, modes);
        modes.depth_m = glided_depth_m(old_modes.depth_m, modes.depth_m, share);
        for (SineField field : old_modes.sines) {
            field.share *= -1.0;
            modes.sines.push_back(std::move(field));
        }
    }
    return sea;
}

WaveGrowth SeaTransition::growing_at(TimeUs time_us) const {
    if (time_us <= start_us_ || time_us >= end_us_)
        return {};
    return {growth(time_us), glide_rate(time_us, start_us_, end_us_)};
}

bool SeaTransition::changes_depth() const {
    const auto depth_m = [](const CascadeModes& modes) { return modes.depth_m; };
    return !std::ranges::equal(fading_->cascades, growing_->cascades, {}, depth_m, depth_m);
}

FieldSet SeaTransition::grown() const {
    return values_of_rates(surface_fields).without(grown_otherwise());
}

FieldSet SeaTransition::grown_otherwise() const {
    return changes_depth() ? following(Field::height) : FieldSet{};
}

void SeaTransition::add_growth(std::span<float> rate, std::span<const float> grown,
                               TimeUs time_us) const {
    const auto rate_hz = static_cast<float>(glide_rate(time_us, start_us_, end_us_));
    std::ranges::transform(rate, grown, rate.begin(),
                           [rate_hz](float a, float b) { return a + rate_hz * b; });
}

RealizationPtr SeaTransition::displacement_growth(TimeUs time_us, std::uint32_t cascades) const {
    const RealizationPtr waves = gliding(time_us, cascades);
    auto sea = std::make_shared<Realization>(*growth(time_us, cascades));
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        CascadeModes& modes = sea->cascades[c];
        if (!modes.is_there())
            continue;
        const double per_depth =
            1.0 / growing_->cascades[c].depth_m - 1.0 / fading_->cascades[c].depth_m;
        for_each_lattice_mode(modes.spec, [&](double k_radpm, std::size_t i) {
            modes.h0[i] +=
                waves->cascades[c].h0[i] * (per_depth * orbit_growth_m(k_radpm, modes.depth_m));
        });
    }
    return sea;
}

RealizationPtr SeaTransition::envelope() const {
    auto sea = std::make_shared<Realization>(*growing_);
    sea->choppiness = {std::max(fading_->choppiness.x, growing_->choppiness.x),
                       std::max(fading_->choppiness.y, growing_->choppiness.y)};
    for (std::size_t c = 0; c < sea->cascades.size(); ++c) {
        CascadeModes& modes = sea->cascades[c];
        const CascadeModes& old_modes = fading_->cascades[c];
        for (std::size_t i = 0; i < modes.h0.size(); ++i)
            if (std::norm(old_modes.h0[i]) > std::norm(modes.h0[i]))
                modes.h0[i] = old_modes.h0[i];
        add_given(old_modes, modes);
        modes.depth_m = std::min(old_modes.depth_m, modes.depth_m);
        modes.sines.insert(modes.sines.end(), old_modes.sines.begin(), old_modes.sines.end());
    }
    return sea;
}

} // namespace seaway::sea
