// SPDX-License-Identifier: Apache-2.0
#include "server/simulation/price.h"

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
    FoamMaps foam(course_);
    const RunningSea& sea = *course_->first();
    for (std::size_t c = 0; c < sea.realization->cascades.size(); ++c) {
        const double size = sea.realization->cascades[c].spec.size;
        samples_.push_back(size * size);
        all_samples_ += size * size;
        foam_start_ticks_.push_back(sea.foam_law ? foam.ticks_to(static_cast<int>(c), 0) : 0);
    }
    prompt_us_ = surface_us(0, [](const KeyframeRequest&) { return Holding::nothing; }) +
                 prompt_points * price_point_us;
}

double Prices::keyframes_us(std::span<const KeyframeRequest> wanted, const HoldingOf& held) const {
    Lookups look(held);
    double us = 0;
    const KeyframeRequest* walked = nullptr; // the one before, with foam
    for (const KeyframeRequest& request : wanted) {
        if (look(request) != Holding::nothing)
            continue;
        const double one = samples(request.cascade);
        us += one * with_foam_inputs(request.fields).size() * price_sample_us;
        if (!request.fields.contains(sea::Field::foam))
            continue;
        double ticks = foam_start_ticks_[static_cast<std::size_t>(request.cascade)];
        if (walked && walked->cascade == request.cascade && walked->time_us <= request.time_us)
            ticks = std::min(ticks, 1.0 + static_cast<double>(request.time_us - walked->time_us) /
                                              static_cast<double>(sea::foam_tick_min_us));
        us += ticks * one * price_foam_sample_us;
        walked = &request;
    }
    return us;
}

double Prices::surfaces_us(std::vector<TimeUs> times_us, const HoldingOf& held) const {
    Lookups look(held);
    const sea::FieldSet fields = course_->first()->sampler_fields();
    double us = 0;
    for (const KeyframeRequest& request : keyframes_around(*course_, times_us, {~0u, fields})) {
        const double one = samples(request.cascade) * fields.size();
        const Holding holding = look(request);
        us += holding == Holding::nothing ? one * price_sample_us : 0;
        us += holding != Holding::spline ? one * price_spline_sample_us : 0;
    }
    return us;
}

double Prices::folds_factor(std::span<const sea::QueryPoint> points) const {
    return !points.empty() && fold_search(course_->at(points.front().time_us)->budget).always
               ? price_folds_factor
               : 1;
}

double Prices::points_us(std::span<const sea::QueryPoint> points, const HoldingOf& held) const {
    const double folds = folds_factor(points);
    return surfaces_us(times_of(points), held) +
           static_cast<double>(points.size()) * folds * price_point_us;
}

double Prices::exact_us(std::span<const sea::QueryPoint> points) const {
    const double folds = folds_factor(points);
    return all_samples_ * (static_cast<double>(times_of(points).size()) * price_moment_wave_us +
                           static_cast<double>(points.size()) * folds * price_exact_wave_us);
}

double Prices::surface_us(TimeUs time_us, const HoldingOf& held) const {
    return surfaces_us({time_us}, held);
}

} // namespace seaway::server
