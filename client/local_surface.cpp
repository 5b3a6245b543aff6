// SPDX-License-Identifier: Apache-2.0
#include "client/local_surface.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "client/link/failure.h"
#include "sea/surface/budget/error_budget.h"

namespace seaway::client {

using sea::Field;

namespace {

/// Bound of a value of this pair at any time between the two, in the unit of the value.
double sampled_error(const KeyframePair& pair, Field value, Field rate, double interval_s) {
    const auto larger = [&](Field field) {
        return static_cast<double>(std::max(pair.before->error(field), pair.after->error(field)));
    };
    return sea::sampled_codec_error(larger(value), larger(rate), interval_s);
}

sea::FoldSearch folds_of(const SeaState& state) {
    return sea::fold_search(state.displacement_reach_m, {state.choppiness_x, state.choppiness_y},
                            state.rms_strain);
}

} // namespace

sea::MapError local_map_error(const SeaState& state, std::span<const KeyframePair> pairs) {
    sea::MapError error;
    error.interpolation_m = state.interpolation_error_m;
    error.interpolation_displacement_m = state.interpolation_displacement_m;
    error.interpolation_strain = state.interpolation_strain;
    for (const KeyframePair& pair : pairs) {
        const auto cascade = static_cast<std::size_t>(pair.before->keyframe().cascade);
        const double interval_s = sea::seconds_from_us(state.cascades[cascade].interval_us);
        error.codec_height_m += sampled_error(pair, Field::height, Field::height_rate, interval_s);
        const double x_m =
            sampled_error(pair, Field::displacement_x, Field::displacement_x_rate, interval_s);
        const double y_m =
            sampled_error(pair, Field::displacement_y, Field::displacement_y_rate, interval_s);
        const double sideways_m = std::hypot(state.choppiness_x * x_m, state.choppiness_y * y_m);
        const sea::Keyframe& map = pair.before->keyframe();
        error.codec_displacement_m += sideways_m;
        error.codec_strain += sea::sampled_slope_error(sideways_m, map.length_m / map.size);
    }
    return error;
}

Result<LocalSurface> local_surface(const SeaState& state, const KeyframeRing& ring,
                                   sea::TimeUs time_us, sea::FieldSet fields) {
    std::vector<KeyframePair> pairs;
    std::vector<sea::SplinePair> splines;
    bool covered = true;
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        std::optional<KeyframePair> pair = ring.around(static_cast<int>(c), state.epoch, time_us,
                                                       state.cascades[c].interval_us, fields);
        if (!pair || !pair->before->can_be_sampled() || !pair->after->can_be_sampled())
            return failed(Failure::not_held,
                          fmt::format("no keyframe of cascade {} is held that heights can be "
                                      "sampled from: subscribe, or fetch around the time",
                                      c));
        covered = covered && pair->covers;
        splines.push_back({pair->before->spline(), pair->after->spline()});
        pairs.push_back(std::move(*pair));
    }
    return LocalSurface{sea::Surface(std::move(splines), {state.choppiness_x, state.choppiness_y},
                                     folds_of(state), local_map_error(state, pairs)),
                        covered};
}

bool covers(const SeaState& state, const KeyframeRing& ring, sea::TimeUs time_us,
            sea::FieldSet fields) {
    for (std::size_t c = 0; c < state.cascades.size(); ++c) {
        const std::optional<KeyframePair> pair = ring.around(
            static_cast<int>(c), state.epoch, time_us, state.cascades[c].interval_us, fields);
        if (!pair || !pair->covers || pair->before == pair->after)
            return false;
    }
    return true;
}

TimeCell time_cell(const SeaState& state, sea::TimeUs time_us) {
    TimeCell cell;
    for (const protocol::CascadeInfo& cascade : state.cascades) {
        const sea::TimeUs rest = time_us % cascade.interval_us;
        cell.push_back((time_us - rest) / cascade.interval_us - (rest < 0 ? 1 : 0));
    }
    return cell;
}

} // namespace seaway::client
