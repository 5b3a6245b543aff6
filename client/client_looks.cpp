// SPDX-License-Identifier: Apache-2.0
// Client: what engines ask beside heights (looks.h).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "client/client.h"
#include "client/link/failure.h"
#include "sea/surface/budget/error_budget.h"
#include "sea/surface/by_time.h"
#include "sea/surface/grid_rows.h"

namespace seaway::client {

using sea::TimeUs;
using sea::Vec2;

namespace {

/// A sea of which nothing is felt; its foam is seen.
void put_flat(const sea::QueryPoint& point, const HeldFoam& foam, Water& water) {
    const double nan = std::nan("");
    const bool is_water = std::isfinite(point.x_m) && std::isfinite(point.y_m);
    water.foam = is_water ? foam.at({point.x_m, point.y_m}) : nan;
    water.foam_late = is_water && foam.is_beyond();
    if (is_water)
        return;
    water.answer = {nan, {nan, nan, nan}, {nan, nan, nan}, nan, sea::answer_invalid};
    water.displacement_m[0] = water.displacement_m[1] = water.jacobian = nan;
}

} // namespace

SourceNow Client::source(TimeUs time_us) const {
    return of_one_sea([&]() -> SourceNow {
        const SeaStatePtr state = sea_state(time_us);
        std::unique_lock lock(mutex_);
        if (holds_waves_held(state)) {
            if (waves_held(state).made)
                return {AnswersFrom::parameters,
                        "the sea was made here from its scene and agrees with the server's probes"};
            return {AnswersFrom::spectrum, "the server sent the waves themselves"};
        }
        lock.unlock();
        const Result<LocalSurface> tiles = local_surface(*state, ring_, time_us, sampled_fields());
        if (!tiles)
            return {AnswersFrom::server, tiles.error().message};
        if (!tiles->covers)
            return {AnswersFrom::tiles,
                    "keyframes are held, but not on both sides of this time: answers are flagged "
                    "as extrapolated"};
        return {AnswersFrom::tiles, "keyframes are held on both sides of this time, and no waves"};
    });
}

Result<void> Client::look_at(std::span<const sea::QueryPoint> points, const Looking& looking,
                             const SeaStatePtr& state, std::span<Water> water) const {
    const TimeUs time_us = points.front().time_us;
    const std::uint32_t cascades = felt_cascades(*state, looking);
    const HeldFoam foam(*state, ring_, time_us);
    const auto put = [&](sea::InverseOptions options, sea::LagrangianField field, double blur_m) {
        // No double far out is as near as those at home.
        const double nearest_m = options.tolerance_m;
        for (std::size_t i = 0; i < points.size(); ++i) {
            options.tolerance_m = std::max(nearest_m, sea::exact_tolerance_m(points[i]));
            const std::optional<Vec2> place =
                put_movement(points[i], options, field, blur_m, water[i]);
            water[i].foam = place ? foam.at(*place) : std::nan("");
            water[i].foam_late = place && foam.is_beyond();
        }
    };
    std::vector<sea::Answer> answers(points.size());
    const auto keep = [&](std::uint32_t flags) {
        for (std::size_t i = 0; i < points.size(); ++i)
            (water[i].answer = answers[i]).flags |= flags;
    };
    if (cascades == 0) {
        for (std::size_t i = 0; i < points.size(); ++i)
            put_flat(points[i], foam, water[i]);
        return check_cascades(*state, looking);
    }
    const WaveBatch batch{time_us, points.size(), 1, cascades};
    std::optional<LocalSurface> held;
    std::shared_ptr<WaveMaps> maps;
    const OwnSeaPtr waves = own_sea(state);
    if (!waves) {
        SEAWAY_TRY_LET(held, local_surface(*state, ring_, time_us, sampled_fields(), cascades));
    } else {
        maps = maps_of_waves_.of(state, waves);
        held = maps->surface(batch);
    }
    if (held) {
        const sea::Surface& surface = held->surface;
        surface.answer(points, answers);
        keep(held->covers ? 0u : sea::answer_extrapolated);
        put(
            {surface.choppiness(), sea::inverse_tolerance_m(state->height_error_m),
             surface.folds()},
            [&](double x_m, double y_m) { return surface.at(x_m, y_m, time_us); },
            surface.fold_blur_m());
        return {};
    }
    const double begun_s = thread_cpu_seconds();
    waves->at(time_us, [&](const RebuiltSea& sea) {
        const auto [moment, laid_out_s] = sea.laid_out(time_us, cascades);
        for (std::size_t i = 0; i < points.size(); ++i)
            answers[i] = sea.answer(points[i], moment);
        maps->summed(batch, 1e6 * (thread_cpu_seconds() - begun_s), 1e6 * laid_out_s);
        keep(0);
        const sea::Choppiness choppiness = sea.sum().sea().choppiness;
        put({choppiness, 1e-7, sea::fold_search(state->displacement_reach_m, choppiness, 0)},
            moment, choppiness.largest() * sea.error().displacement_m);
    });
    return {};
}

Result<std::vector<Water>> Client::look(std::span<const sea::QueryPoint> points,
                                        const Looking& looking) const {
    for (const sea::QueryPoint& point : points)
        SEAWAY_TRY(check_point(point));
    return of_one_sea([&]() -> Result<std::vector<Water>> {
        std::vector<Water> water(points.size());
        for (std::size_t first = 0; first < points.size();) {
            const std::size_t end = sea::same_time_end(points, first);
            const TimeUs time_us = points[first].time_us;
            const std::span<const sea::QueryPoint> asked = points.subspan(first, end - first);
            const std::span<Water> found = std::span(water).subspan(first, end - first);
            const SeaStatePtr state = sea_state(time_us);
            bool certain = known_sea(time_us).has(time_us);
            if (const Result<void> looked = look_at(asked, looking, state, found); !looked) {
                // As heights do (hold_then()).
                const SeaStatePtr before = sea_state(state->start_time_us - 1);
                if (time_us - state->start_time_us >= sea::glide_us_min || before == state ||
                    !look_at(asked, looking, before, found))
                    return looked.error();
                certain = false;
            }
            if (!certain)
                for (Water& one : found)
                    one.answer.flags |= sea::answer_extrapolated;
            first = end;
        }
        std::vector<sea::Answer> answers;
        for (const Water& one : water)
            answers.push_back(one.answer);
        std::vector<double> moved_off_m(points.size(), 0.0);
        mark_stale(points, answers, {}, moved_off_m);
        for (std::size_t i = 0; i < water.size(); ++i) {
            water[i].answer = answers[i];
            water[i].answer.flags |= water[i].foam_late ? sea::answer_foam_late : 0u;
            water[i].displacement_error_m += moved_off_m[i];
            if (answers[i].flags & sea::answer_invalid)
                water[i].displacement_error_m = std::nan("");
        }
        return water;
    });
}

Result<Below> Client::below(std::span<const sea::QueryPoint> points, std::span<const double> z_m,
                            const Looking& looking) const {
    SEAWAY_CHECK(points.size() == z_m.size(), "one depth a point");
    for (const sea::QueryPoint& point : points)
        SEAWAY_TRY(check_point(point));
    return of_one_sea([&]() -> Result<Below> {
        Below found{std::vector<sea::Answer>(points.size()),
                    std::vector<sea::WaterBelow>(points.size())};
        for (std::size_t first = 0; first < points.size();) {
            const TimeUs time_us = points[first].time_us;
            const std::size_t end = sea::same_time_end(points, first);
            const KnownSea known = known_sea(time_us);
            const SeaStatePtr state = sea_state(time_us);
            const OwnSeaPtr waves = own_sea(state);
            if (!waves)
                return failed(Failure::not_held,
                              "water below the surface follows from waves, and none are held of "
                              "that time: subscribe to the spectrum, rebuild the sea, or ask the "
                              "server");
            const std::uint32_t cascades = felt_cascades(*state, looking);
            if (cascades == 0)
                SEAWAY_TRY(check_cascades(*state, looking));
            waves->at(time_us, [&](const RebuiltSea& sea) {
                const sea::DirectSum::Moment moment = sea.sum().at_time(time_us, cascades);
                for (std::size_t i = first; i < end; ++i) {
                    found.answers[i] = sea.answer(points[i], z_m[i], moment, found.water[i]);
                    if (!known.has(time_us))
                        found.answers[i].flags |= sea::answer_extrapolated;
                }
            });
            first = end;
        }
        mark_stale(points, found.answers);
        return found;
    });
}

namespace {

/// Bounds on a value anywhere and at any time between keyframes.
void put_bounds(const sea::Surface& surface, CascadeMap& map) {
    const sea::SplinePair& pair = surface.pairs().front();
    const double interval_s = sea::seconds_from_us(pair.after->time_us() - pair.before->time_us());
    map.error_m = surface.flat_height_bound_m();
    const sea::MapError& error = surface.map_error();
    map.displacement_error_m = error.displacement_bound_m;
    if (!error.cascades.empty())
        map.displacement_error_m +=
            sea::bound_sigmas *
            std::sqrt(error.cascades.front().displacement.largest_variance_m2(interval_s));
}

/// What these channels need of the surface. Of displacements that did not come nothing is said.
sea::FieldSet needed_surface(std::span<const std::optional<sea::Field>> channels) {
    sea::FieldSet needed;
    for (const std::optional<sea::Field>& field : channels) {
        if (field == sea::Field::height || field == sea::Field::height_rate ||
            field == sea::Field::slope_x || field == sea::Field::slope_y)
            needed |= {sea::Field::height, sea::Field::height_rate};
        else if (field && field != sea::Field::foam)
            needed |= sea::surface_fields;
    }
    if (needed.empty() && std::ranges::find(channels, sea::Field::foam) == channels.end())
        return {sea::Field::height, sea::Field::height_rate}; // nothing has a grid all the same
    return needed;
}

/// Without a surface there is foam alone.
void fill(const sea::Surface* surface, TimeUs time_us,
          std::span<const std::optional<sea::Field>> channels,
          const std::optional<KeyframePair>& foam, CascadeMap& map) {
    const auto side = static_cast<std::size_t>(map.size);
    map.values.resize(side * side * channels.size());
    std::optional<sea::GridRows> rows;
    if (surface)
        rows.emplace(surface->pairs().front(), time_us);
    for (std::size_t y = 0; y < side; ++y) {
        const std::span<const sea::LagrangianPoint> row =
            rows ? rows->next() : std::span<const sea::LagrangianPoint>();
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::optional<sea::Field>& field = channels[c];
            float* to = map.values.data() + y * side * channels.size() + c;
            const auto put = [&](const auto& value_at) {
                for (std::size_t x = 0; x < side; ++x, to += channels.size())
                    *to = static_cast<float>(value_at(x));
            };
            if (field == sea::Field::jacobian)
                put([&](std::size_t x) { return sea::jacobian(row[x], surface->choppiness()); });
            else if (field == sea::Field::foam)
                put([&](std::size_t x) {
                    const double texel_m = map.length_m / map.size;
                    return foam_ratio(
                        *foam, time_us,
                        {static_cast<double>(x) * texel_m, static_cast<double>(y) * texel_m});
                });
            else if (field)
                put([&](std::size_t x) { return sea::value_of(row[x], *field); });
        }
    }
}

} // namespace

Result<LocalSurface> Client::surface_of(const SeaStatePtr& state, TimeUs time_us, int cascade,
                                        sea::FieldSet needed, RebuiltError& waves_off) const {
    Result<LocalSurface> came = local_surface(*state, ring_, time_us, needed, 1u << cascade);
    if (came && came->covers)
        return came;
    const OwnSeaPtr waves = own_sea(state);
    const std::shared_ptr<WaveMaps> maps = waves ? maps_of_waves_.of(state, waves) : nullptr;
    std::optional<LocalSurface> made = maps ? maps->map(time_us, cascade) : std::nullopt;
    if (!made)
        return came;
    waves_off = waves->error();
    return *std::move(made);
}

Result<CascadeMap> Client::map(int cascade, TimeUs time_us,
                               std::span<const std::optional<sea::Field>> channels) const {
    SEAWAY_TRY(check_time(time_us));
    return of_one_sea([&]() -> Result<CascadeMap> {
        const KnownSea known = known_sea(time_us);
        const SeaStatePtr state = sea_state(time_us);
        const auto index = static_cast<std::size_t>(cascade);
        if (index >= state->cascades.size())
            return failed(Failure::bad_argument,
                          fmt::format("cascade {}: the sea has {}, from 0 on", cascade,
                                      state->cascades.size()));
        std::optional<KeyframePair> foam;
        if (std::ranges::find(channels, sea::Field::foam) != channels.end()) {
            foam = ring_.around(cascade, state->epoch, time_us, state->cascades[index].interval_us,
                                {sea::Field::foam});
            if (!foam)
                return failed(
                    Failure::not_held,
                    fmt::format("no foam of cascade {} is held around that time", cascade));
        }
        CascadeMap map{.epoch = state->epoch, .foam_mean = state->foam_mean_at(time_us)};
        std::optional<LocalSurface> held;
        const sea::FieldSet needed = needed_surface(channels);
        if (!needed.empty()) {
            RebuiltError waves_off;
            SEAWAY_TRY_LET(held, surface_of(state, time_us, cascade, needed, waves_off));
            const sea::SplineMap& spline = *held->surface.pairs().front().before;
            map.size = spline.size();
            map.length_m = spline.length_m();
            put_bounds(held->surface, map);
            if (cascade != 0) { // whose maps have it
                map.error_m += waves_off.height_m;
                map.displacement_error_m += waves_off.displacement_m;
            }
        } else {
            map.size = foam->before->keyframe().size;
            map.length_m = foam->before->keyframe().length_m;
        }
        sea::Answer marks;
        if ((held && !held->covers) || (foam && !foam->covers) || !known.has(time_us))
            marks.flags |= sea::answer_extrapolated;
        const sea::QueryPoint here{0, 0, time_us};
        mark_stale({&here, 1}, {&marks, 1});
        map.flags = marks.flags;
        fill(held ? &held->surface : nullptr, time_us, channels, foam, map);
        return map;
    });
}

} // namespace seaway::client
