// SPDX-License-Identifier: Apache-2.0
// How the simulation answers: batches of points, slice by slice, from surfaces around their times.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "server/simulation/simulation.h"

namespace seaway::server {

using sea::TimeUs;

struct Simulation::Batch {
    std::vector<sea::QueryPoint> points;
    std::vector<std::size_t> order; ///< by time: points that share keyframes stand together
    std::vector<sea::Answer> answers;
    std::size_t done_count = 0;                   ///< of `order`
    std::optional<sea::DirectSum::Moment> moment; ///< exact: the sea at moment_us
    TimeUs moment_us = 0;
    Answered done;

    bool complete() const { return done_count == order.size(); }
    const sea::QueryPoint& next() const { return points[order[done_count]]; }
    void put(const sea::Answer& answer) { answers[order[done_count++]] = answer; }
};

void Simulation::answer(std::vector<sea::QueryPoint> points, bool exact, Answered done) {
    auto batch = std::make_shared<Batch>();
    batch->points = std::move(points);
    batch->answers.resize(batch->points.size());
    batch->done = std::move(done);
    batch->order.resize(batch->points.size());
    std::iota(batch->order.begin(), batch->order.end(), std::size_t{0});
    std::stable_sort(batch->order.begin(), batch->order.end(), [&](std::size_t a, std::size_t b) {
        return batch->points[a].time_us < batch->points[b].time_us;
    });
    const bool taken = ask([this, batch, exact] {
        if (!(exact ? exact_slice(*batch) : answer_slice(*batch)))
            return false;
        batch->done(std::move(batch->answers));
        return true;
    });
    if (!taken)
        batch->done({});
}

bool Simulation::exact_slice(Batch& batch) const {
    const sea::FoldSearch folds = fold_search(sea_->budget);
    for (std::size_t i = 0; i < exact_points_per_slice && !batch.complete(); ++i) {
        const sea::QueryPoint& point = batch.next();
        if (!batch.moment || batch.moment_us != point.time_us) {
            batch.moment = sea_->truth.at_time(point.time_us);
            batch.moment_us = point.time_us;
        }
        // A nanometre, and what rounding leaves of a coordinate far out.
        const double tolerance_m =
            1e-9 + 4e-16 * std::max(std::abs(point.x_m), std::abs(point.y_m));
        sea::Answer answer = sea::surface_at(
            point, {sea_->realization->choppiness, tolerance_m, folds}, *batch.moment);
        answer.error_m += tolerance_m;
        answer.flags |= sea::answer_exact;
        batch.put(answer);
    }
    return batch.complete();
}

bool Simulation::answer_slice(Batch& batch) {
    if (batch.complete())
        return true;
    const std::optional<SurfaceSpan> span = surface_around(batch.next().time_us);
    if (!span) { // the device is gone for good
        batch.answers.clear();
        return true;
    }
    for (std::size_t i = 0;
         i < sampled_points_per_slice && !batch.complete() && batch.next().time_us < span->end_us;
         ++i)
        batch.put(span->surface.answer(batch.next()));
    return batch.complete();
}

std::optional<Simulation::SurfaceSpan> Simulation::surface_around(TimeUs time_us) {
    const std::vector<Wanted> wanted = around(time_us, {~0u, sea_->sampler_fields()});
    const std::vector<sea::KeyframePtr> held = keyframes(wanted, asked_foam_);
    if (held.size() != wanted.size())
        return std::nullopt;
    std::vector<sea::SplinePair> pairs;
    TimeUs end_us = std::numeric_limits<TimeUs>::max();
    for (std::size_t i = 0; i < wanted.size(); i += 2) {
        pairs.push_back({store_.spline(held[i]), store_.spline(held[i + 1])});
        end_us = std::min(end_us, wanted[i + 1].time_us);
    }
    return SurfaceSpan{sea::Surface(std::move(pairs), sea_->realization->choppiness,
                                    fold_search(sea_->budget), map_error(sea_->budget, 0.0)),
                       end_us};
}

void Simulation::surface(TimeUs time_us, Surfaced done) {
    const bool taken = ask([this, time_us, done] {
        const std::optional<SurfaceSpan> span = surface_around(time_us);
        done(span ? &span->surface : nullptr);
        return true;
    });
    if (!taken)
        done(nullptr);
}

} // namespace seaway::server
