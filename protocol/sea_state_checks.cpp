// SPDX-License-Identifier: Apache-2.0
// Ranges of the values in a verified SeaState (protocol/messages.h).
#include <limits>

#include "protocol/value_checks.h"
#include "sea/basics/foam_range.h"
#include "sea/surface/steepest_sea.h"

namespace seaway::protocol {
namespace {

/// A flat sea has zeros.
Result<void> check_numbers(std::string_view of, const wire::SeaNumbers* numbers) {
    if (numbers == nullptr)
        return {};
    const auto name = [of](std::string_view field) { return std::string(of) + std::string(field); };
    constexpr double most = 1e9, steepest = 1e300; // that it is a number
    return all_of(in_range(name(".hs_m"), numbers->hs_m(), 0.0, most),
                  in_range(name(".tp_s"), numbers->tp_s(), 0.0, most),
                  in_range(name(".tz_s"), numbers->tz_s(), 0.0, most),
                  in_range(name(".tm01_s"), numbers->tm01_s(), 0.0, most),
                  in_range(name(".mean_from_deg"), numbers->mean_from_deg(), -360.0, 360.0),
                  in_range(name(".spread_deg"), numbers->spread_deg(), 0.0, 360.0),
                  in_range(name(".mss"), numbers->mss(), 0.0, steepest));
}

Result<void> check_glide(const wire::SeaState& state) {
    const wire::Glide* glide = state.glide();
    if (glide == nullptr)
        return {};
    return all_of(
        in_range("glide.end_us", glide->end_us(), state.start_time_us(), limits::time_us_max),
        in_range("glide.choppiness_x", glide->choppiness_x(), -10.0, 10.0),
        in_range("glide.choppiness_y", glide->choppiness_y(), -10.0, 10.0),
        in_range("glide.foam_mean", glide->foam_mean(), 0.0, sea::foam_mean_max),
        in_range("glide.foam_threshold", glide->foam_threshold(), -1.0, 1.0));
}

/// None, or one a cascade.
Result<void> check_losses(const wire::SeaState& state) {
    if (count(state.losses()) == 0)
        return {};
    SEAWAY_TRY(in_range<std::size_t>("count of losses", count(state.losses()),
                                     count(state.cascades()), count(state.cascades())));
    for (const wire::CascadeLoss* loss : *state.losses())
        SEAWAY_TRY(
            all_of(in_range("time_m", loss->time_m(), 0.0f, 1e9f),
                   in_range("east_m", loss->east_m(), 0.0f, 1e9f),
                   in_range("north_m", loss->north_m(), 0.0f, 1e9f),
                   in_range("displacement_time_m", loss->displacement_time_m(), 0.0f, 1e9f),
                   in_range("displacement_east_m", loss->displacement_east_m(), 0.0f, 1e9f),
                   in_range("displacement_north_m", loss->displacement_north_m(), 0.0f, 1e9f)));
    return {};
}

/// None, or one a cascade.
Result<void> check_longest(const wire::SeaState& state) {
    const auto* longest = state.glide_k_lo_radpm();
    if (count(longest) == 0)
        return {};
    SEAWAY_TRY(in_range<std::size_t>("count of glide_k_lo_radpm", count(longest),
                                     count(state.cascades()), count(state.cascades())));
    for (const double k_radpm : *longest)
        SEAWAY_TRY(in_range("glide_k_lo_radpm", k_radpm, 0.0, 1e9));
    return {};
}

/// Where a client evaluates a sea must be where seas are, and what it is held against must be numbers.
Result<void> check_probes(const std::string& name,
                          const flatbuffers::Vector<const wire::Probe*>* probes) {
    SEAWAY_TRY(in_range<std::size_t>("count of " + name, count(probes), 0, limits::probes_max));
    for (flatbuffers::uoffset_t i = 0; i < count(probes); ++i) {
        const wire::Probe& probe = *probes->Get(i);
        constexpr double most = limits::position_m_max;
        SEAWAY_TRY(all_of(
            in_range(name + ".x_m", probe.x_m(), -most, most),
            in_range(name + ".y_m", probe.y_m(), -most, most),
            in_range(name + ".time_us", probe.time_us(), -limits::time_us_max, limits::time_us_max),
            in_range(name + ".height_m", probe.height_m(), -most, most),
            in_range(name + ".displacement_x_m", probe.displacement_x_m(), -most, most),
            in_range(name + ".displacement_y_m", probe.displacement_y_m(), -most, most)));
    }
    return {};
}

/// Of many the text may be the same bytes of the message.
Result<void> check_warnings(const wire::SeaState& state) {
    SEAWAY_TRY(in_range<std::size_t>("count of warnings", count(state.warnings()), 0,
                                     limits::warnings_max));
    for (flatbuffers::uoffset_t i = 0; i < count(state.warnings()); ++i)
        SEAWAY_TRY(text_fits("warnings", state.warnings()->Get(i), limits::warning_bytes_max));
    return {};
}

} // namespace

Result<void> check(const wire::SeaState& state) {
    Result<void> fine = all_of(
        in_range<std::size_t>("count of cascades", count(state.cascades()), 0,
                              limits::cascades_max),
        in_range("start_time_us", state.start_time_us(), -limits::time_us_max, limits::time_us_max),
        in_range("choppiness_x", state.choppiness_x(), -10.0, 10.0),
        in_range("choppiness_y", state.choppiness_y(), -10.0, 10.0),
        in_range("height_error_m", state.height_error_m(), 0.0, 1e6),
        in_range("interpolation_error_m", state.interpolation_error_m(), 0.0,
                 sea::told_error_m_max),
        in_range("rms_slope", state.rms_slope(), 0.0, sea::told_slope_max),
        in_range("curvature_per_m", state.curvature_per_m(), 0.0, sea::told_curvature_per_m_max),
        in_range("foam_mean", state.foam_mean(), 0.0, sea::foam_mean_max),
        in_range("foam_threshold", state.foam_threshold(), -1.0, 1.0),
        in_range("displacement_reach_m", state.displacement_reach_m(), 0.0, sea::told_sideways_max),
        in_range("rms_strain", state.rms_strain(), 0.0, sea::told_sideways_max),
        in_range("interpolation_displacement_m", state.interpolation_displacement_m(), 0.0,
                 sea::told_sideways_max),
        in_range("interpolation_strain", state.interpolation_strain(), 0.0, sea::told_sideways_max),
        in_range("single_precision_m", state.single_precision_m(), 0.0, sea::told_error_m_max),
        in_range("single_precision_displacement_m", state.single_precision_displacement_m(), 0.0,
                 sea::told_sideways_max),
        check_glide(state), check_numbers("requested", state.requested()),
        check_numbers("realised", state.realised()),
        check_numbers("realised_before", state.realised_before()),
        in_range("depth_m", state.depth_m(), 0.0, std::numeric_limits<double>::infinity()),
        in_range("bottom_red", state.bottom_red(), 0.0f, 1.0f),
        in_range("bottom_green", state.bottom_green(), 0.0f, 1.0f),
        in_range("bottom_blue", state.bottom_blue(), 0.0f, 1.0f), check_losses(state),
        in_range("probe_error_m", state.probe_error_m(), 0.0, 1e6),
        check_probes("probes", state.probes()), check_probes("leads_to", state.leads_to()),
        check_longest(state), check_warnings(state),
        state.wave_law() ? check_law("wave_law.", *state.wave_law()) : Result<void>());
    if (!fine || state.cascades() == nullptr)
        return fine;
    for (const wire::CascadeInfo* cascade : *state.cascades()) {
        fine = all_of(
            in_range("length_m", cascade->length_m(), 1e-3, 1e9),
            in_range<std::uint32_t>("size", cascade->size(), 1, limits::map_side_max),
            in_range<std::int64_t>("interval_us", cascade->interval_us(), 1, interval_us_max),
            in_range("k_lo_radpm", cascade->k_lo_radpm(), 0.0, 1e9),
            in_range("k_hi_radpm", cascade->k_hi_radpm(), 0.0, 1e9));
        if (!fine)
            break;
    }
    return fine;
}

} // namespace seaway::protocol
