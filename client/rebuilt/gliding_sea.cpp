// SPDX-License-Identifier: Apache-2.0
#include "client/rebuilt/gliding_sea.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "client/link/failure.h"
#include "sea/basics/cascade.h"
#include "sea/surface/by_time.h"

namespace seaway::client {
namespace {

/// What its waves are off by in water of another depth: a wave that was rounded moves sideways as one of its length does there. All
/// waves are rounded alike.
RebuiltError in_depth(RebuiltError error, const sea::Realization& waves, double depth_m) {
    double own = 0, there = 0, own_strain = 0, strain_there = 0;
    if (std::ranges::all_of(waves.cascades, [&](const sea::CascadeModes& modes) {
            return modes.depth_m == depth_m;
        }))
        return error;
    for (const sea::CascadeModes& modes : waves.cascades) {
        const double dk = modes.spec.wavenumber_step_radpm();
        const auto n = static_cast<std::size_t>(modes.spec.size);
        for (std::size_t i = 0; i < modes.h0.size(); ++i) {
            if (modes.h0[i] == std::complex<double>{})
                continue;
            const double k =
                dk * std::hypot(sea::signed_index(static_cast<int>(i % n), modes.spec.size),
                                sea::signed_index(static_cast<int>(i / n), modes.spec.size));
            const auto square = [](double x) { return x * x; };
            const double here = square(sea::orbit_aspect(k, modes.depth_m));
            const double then = square(sea::orbit_aspect(k, depth_m));
            own += here;
            there += then;
            own_strain += here * k * k;
            strain_there += then * k * k;
        }
    }
    if (own > 0) {
        error.displacement_m *= std::sqrt(there / own);
        error.strain *= std::sqrt(strain_there / own_strain);
    }
    return error;
}

double shallowest_m(const sea::Realization& a, const sea::Realization& b) {
    double depth_m = std::numeric_limits<double>::infinity();
    for (const sea::Realization* sea : {&a, &b})
        for (const sea::CascadeModes& modes : sea->cascades)
            depth_m = std::min(depth_m, modes.depth_m);
    return depth_m;
}

/// The same sea, with notes of phase such that a transition finds `to` to go on where it stands and turns nothing: that
/// has been done where the waves of `to` were made.
sea::RealizationPtr continued_by(const sea::Realization& from, const sea::Realization& to,
                                 sea::TimeUs start_us) {
    auto noted = std::make_shared<sea::Realization>(from);
    const sea::TimeUs from_us = from.phase_time(start_us), to_us = to.phase_time(start_us);
    for (std::size_t c = 0; c < std::min(from.cascades.size(), to.cascades.size()); ++c) {
        sea::CascadeModes& modes = noted->cascades[c];
        const std::vector<sea::Rate>& later = to.cascades[c].rate;
        modes.phase_offset_turns.assign(modes.rate.size(), 0);
        for (std::size_t i = 0; i < std::min(modes.rate.size(), later.size()); ++i) {
            const sea::Rate rate = later[i] == 0 ? modes.rate[i] : later[i];
            modes.phase_offset_turns[i] =
                sea::phase_turns(rate, to_us) - sea::phase_turns(modes.rate[i], from_us);
        }
    }
    return noted;
}

} // namespace

Result<std::shared_ptr<const GlidingSea>> GlidingSea::create(const protocol::SeaStateValues& state,
                                                             const OwnSea& from, const OwnSea& to,
                                                             sea::TimeUs start_us,
                                                             sea::TimeUs end_us, Phases phases) {
    const sea::RealizationPtr began = from.waves_at(start_us), ends = to.waves_at(end_us);
    const double depth_m = shallowest_m(*began, *ends);
    sea::RealizationPtr before = began, after = ends;
    if (phases == Phases::as_sent) {
        const auto later = std::make_shared<sea::Realization>(*after);
        for (sea::CascadeModes& modes : later->cascades)
            modes.phase_offset_turns.clear(); // its h0 stands as it is
        before = continued_by(*before, *later, start_us);
        after = later;
    }
    Result<sea::SeaTransition> change =
        sea::SeaTransition::create(std::move(before), std::move(after), start_us, end_us);
    if (!change)
        return failed(Failure::not_held, change.error().message);
    // Shares that add up to one of two errors that have nothing to do with each other, at the depth where displacements are widest.
    const RebuiltError a = in_depth(from.error(), *began, depth_m);
    const RebuiltError b = in_depth(to.error(), *ends, depth_m);
    const RebuiltError error{std::max(a.height_m, b.height_m),
                             std::max(a.displacement_m, b.displacement_m),
                             std::max(a.strain, b.strain)};
    return std::shared_ptr<const GlidingSea>(new GlidingSea(*std::move(change), state, error));
}

std::shared_ptr<const RebuiltSea> GlidingSea::at(sea::TimeUs time_us) const {
    {
        const std::scoped_lock lock(mutex_);
        for (const Moment& moment : moments_)
            if (moment.sea && moment.time_us == time_us)
                return moment.sea;
    }
    // Some milliseconds, for which nobody who asks about another time waits.
    auto made = std::make_shared<const RebuiltSea>(change_.at(time_us), state_, error_,
                                                   change_.growing_at(time_us));
    const std::scoped_lock lock(mutex_);
    moments_[oldest_] = {time_us, made};
    oldest_ = (oldest_ + 1) % moments_.size();
    return made;
}

double GlidingSea::answer(std::span<const sea::QueryPoint> points, std::span<sea::Answer> answers,
                          std::span<sea::ErrorTerms> terms, std::uint32_t cascades) const {
    double laid_out_s = 0;
    for (std::size_t first = 0; first < points.size();) {
        const std::size_t end = sea::same_time_end(points, first);
        const double took_s =
            at(points[first].time_us)
                ->answer(points.subspan(first, end - first), answers.subspan(first, end - first),
                         terms.empty() ? terms : terms.subspan(first, end - first), cascades);
        laid_out_s = first == 0 ? took_s : laid_out_s;
        first = end;
    }
    return laid_out_s;
}

} // namespace seaway::client
