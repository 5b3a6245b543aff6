// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/price.h"

#include <algorithm>

#include "sea/surface/maps/sine_maps.h"
#include "server/simulation/fetched_seas.h"
#include "server/simulation/foam_maps.h"
#include "server/simulation/schedule.h"

namespace seaway::server {

using sea::TimeUs;

namespace {

/// The first lookups, then nothing is held.
class Lookups {
  public:
    explicit Lookups(const HoldingOf& held) : held_(held) {}
    Holding operator()(const KeyframeRequest& request) {
        return left_-- > 0 ? held_(request) : Holding::nothing;
    }

  private:
    const HoldingOf& held_;
    int left_ = price_lookups_max;
};

void sort_once(std::vector<TimeUs>& times_us) {
    std::ranges::sort(times_us);
    times_us.erase(std::unique(times_us.begin(), times_us.end()), times_us.end());
}

/// Stylised waves at one point.
double stylised_us(const sea::CascadeModes& modes) {
    double us = 0;
    for (const sea::SineField& field : modes.sines) {
        const double one = field.kind == sea::SineKind::sine    ? price_plane_sine_us
                           : field.kind == sea::SineKind::noise ? price_octave_us
                                                                : price_sharp_sine_us;
        us += one * static_cast<double>(sea::sine_terms(field));
    }
    return us;
}

std::vector<TimeUs> times_of(std::span<const sea::QueryPoint> points) {
    std::vector<TimeUs> times_us;
    for (const sea::QueryPoint& point : points)
        if (times_us.empty() || times_us.back() != point.time_us)
            times_us.push_back(point.time_us);
    sort_once(times_us);
    return times_us;
}

} // namespace

Prices::Prices(SeaCoursePtr course) : course_(std::move(course)) {
    const RunningSea& sea = *course_->first();
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        const double size = sea.realization->cascades[c].spec.size;
        samples_.push_back(size * size);
        all_samples_ += size * size;
        foam_start_ticks_.push_back(0);
        if (!sea.foam_law)
            continue;
        sea::FoamWalk walk(sea.foam_law, static_cast<int>(c), sea.budget.cascades[c].interval_us);
        walk.follow([&](TimeUs) { return sea.foam_law; });
        foam_start_ticks_.back() = walk.ticks_to(0);
    }
    prompt_us_ = surface_us(0, [](const KeyframeRequest&) { return Holding::nothing; }) +
                 prompt_points * price_point_us;
}

double Prices::keyframe_us(const KeyframeRequest& wanted) const {
    const double one = samples(wanted.cascade);
    double us = one * with_foam_inputs(wanted.fields).size() * price_sample_us;
    if (SeaCourse::is_glide(wanted.epoch)) // the waves of the moment, and what they grow by
        us += 2 * one * price_glide_wave_us;
    if ((wanted.fields & sea::sine_fields).empty())
        return us;
    const RunningSeaPtr held = course_->sea_if_held(wanted.epoch);
    const sea::Realization& sea = *(held ? held : course_->first())->realization;
    return us + one * stylised_us(sea.cascades[static_cast<std::size_t>(wanted.cascade)]);
}

double Prices::foam_start_ticks(int cascade) const {
    const bool calm =
        course_->epochs() == 1 && sea::foam_idle(*course_->first()->foam_law, cascade);
    return calm ? 0 : foam_start_ticks_[static_cast<std::size_t>(cascade)];
}

double Prices::keyframes_us(std::span<const KeyframeRequest> wanted, const HoldingOf& held) const {
    Lookups look(held);
    double us = 0;
    const KeyframeRequest* walked = nullptr; // the one before, with foam
    for (const KeyframeRequest& request : wanted) {
        if (look(request) != Holding::nothing)
            continue;
        us += keyframe_us(request);
        if (!request.fields.contains(sea::Field::foam))
            continue;
        const double one = samples(request.cascade);
        double ticks = foam_start_ticks(request.cascade);
        if (walked && walked->cascade == request.cascade && walked->time_us <= request.time_us)
            ticks = std::min(ticks, 1.0 + static_cast<double>(request.time_us - walked->time_us) /
                                              static_cast<double>(sea::foam_tick_min_us));
        us += ticks * one * price_foam_sample_us;
        walked = &request;
    }
    return us;
}

double Prices::surfaces_us(std::vector<TimeUs> times_us, const HoldingOf& held,
                           std::uint32_t cascades) const {
    Lookups look(held);
    const sea::FieldSet fields = course_->first()->sampler_fields();
    double us = seas_us(epochs_at(times_us));
    for (const KeyframeRequest& request : expected_around(times_us, {cascades, fields})) {
        const double one = samples(request.cascade) * fields.size();
        const Holding holding = look(request);
        us += holding == Holding::nothing ? keyframe_us(request) : 0;
        us += holding != Holding::spline ? one * price_spline_sample_us : 0;
    }
    return us;
}

std::vector<std::uint32_t> Prices::epochs_at(std::span<const TimeUs> times_us) const {
    std::vector<std::uint32_t> epochs;
    for (const TimeUs time_us : times_us)
        epochs.push_back(course_->window_at(time_us).epoch);
    std::ranges::sort(epochs);
    epochs.erase(std::unique(epochs.begin(), epochs.end()), epochs.end());
    return epochs;
}

double Prices::seas_us(std::span<const std::uint32_t> epochs) const {
    double us = 0;
    for (const std::uint32_t epoch : epochs)
        if (!course_->sea_if_held(epoch))
            us += all_samples_ * price_sea_wave_us * (SeaCourse::is_glide(epoch) ? 2 : 1);
    return us;
}

std::vector<KeyframeRequest> Prices::expected_around(std::span<const TimeUs> times_us,
                                                     const Demand& demand) const {
    return keyframes_around(
        [this](TimeUs time_us) {
            const std::uint32_t epoch = course_->window_at(time_us).epoch;
            const RunningSeaPtr sea = course_->sea_if_held(epoch);
            return SeaOfTime{epoch, sea ? sea : course_->first()};
        },
        times_us, demand);
}

double Prices::fetch_us(std::vector<TimeUs> times_us, const Demand& demand,
                        const HoldingOf& held) const {
    sort_once(times_us);
    return seas_us(fetched_epochs(*course_, times_us, demand.fields)) +
           keyframes_us(expected_around(times_us, demand), held);
}

double Prices::folds_factor(std::span<const sea::QueryPoint> points) const {
    if (points.empty())
        return 1;
    const RunningSeaPtr sea =
        course_->sea_if_held(course_->window_at(points.front().time_us).epoch);
    return fold_search((sea ? sea : course_->first())->budget).always ? price_folds_factor : 1;
}

double Prices::points_us(std::span<const sea::QueryPoint> points, const HoldingOf& held,
                         std::uint32_t cascades) const {
    const double folds = folds_factor(points);
    return surfaces_us(times_of(points), held, cascades) +
           static_cast<double>(points.size()) * folds * price_point_us;
}

double Prices::exact_us(std::span<const sea::QueryPoint> points, std::size_t depths) const {
    const double folds = folds_factor(points);
    const std::vector<TimeUs> times_us = times_of(points);
    const auto gliding = static_cast<double>(std::ranges::count_if(times_us, [this](TimeUs t_us) {
        return SeaCourse::is_glide(course_->window_at(t_us).epoch);
    }));
    return seas_us(epochs_at(times_us)) +
           all_samples_ * (static_cast<double>(times_us.size()) * price_moment_wave_us +
                           gliding * price_glide_wave_us +
                           static_cast<double>(points.size()) * folds * price_exact_wave_us +
                           static_cast<double>(depths) * price_below_wave_us);
}

double Prices::surface_us(TimeUs time_us, const HoldingOf& held) const {
    return surfaces_us({time_us}, held, sea::all_cascades);
}

} // namespace seaway::server
