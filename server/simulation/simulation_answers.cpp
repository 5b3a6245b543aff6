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

    bool complete() const { return done_count == order.size(); }
    const sea::QueryPoint& next() const { return points[order[done_count]]; }
    void put(const sea::Answer& answer) { answers[order[done_count++]] = answer; }
};

void Simulation::answer(std::vector<sea::QueryPoint> points, bool exact, Answered done) {
    for (const sea::QueryPoint& point : points)
        if (const Result<void> fine = check_point(point); !fine)
            return done(fine.error());
    auto batch = std::make_shared<Batch>();
    batch->points = std::move(points);
    batch->answers.resize(batch->points.size());
    batch->order.resize(batch->points.size());
    std::iota(batch->order.begin(), batch->order.end(), std::size_t{0});
    std::stable_sort(batch->order.begin(), batch->order.end(), [&](std::size_t a, std::size_t b) {
        return batch->points[a].time_us < batch->points[b].time_us;
    });
    ask({[this, batch, exact, done] {
             const std::size_t before = batch->done_count;
             if (exact)
                 exact_slice(*batch);
             else if (const Result<void> sampled = sampled_slice(*batch); !sampled)
                 return done(sampled.error()), true;
             SEAWAY_CHECK(batch->complete() || batch->done_count > before,
                          "each slice brings a question nearer to its end");
             if (batch->complete())
                 done(std::move(batch->answers));
             return batch->complete();
         },
         done});
}

void Simulation::exact_slice(Batch& batch) const {
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
}

Result<void> Simulation::sampled_slice(Batch& batch) {
    if (batch.complete())
        return {};
    SEAWAY_TRY_LET(const SurfaceSpan span, surface_around(batch.next().time_us));
    for (std::size_t i = 0;
         i < sampled_points_per_slice && !batch.complete() && batch.next().time_us < span.end_us;
         ++i)
        batch.put(span.surface->answer(batch.next()));
    return {};
}

Result<Simulation::SurfaceSpan> Simulation::surface_around(TimeUs time_us) {
    const std::vector<Wanted> wanted = around(time_us, {~0u, sea_->sampler_fields()});
    SEAWAY_TRY_LET(const std::vector<sea::KeyframePtr> held, keyframes(wanted, asked_foam_));
    std::vector<sea::SplinePair> pairs;
    TimeUs end_us = std::numeric_limits<TimeUs>::max();
    for (std::size_t i = 0; i < wanted.size(); i += 2) {
        pairs.push_back({store_.spline(held[i]), store_.spline(held[i + 1])});
        end_us = std::min(end_us, wanted[i + 1].time_us);
    }
    return SurfaceSpan{std::make_shared<const sea::Surface>(
                           std::move(pairs), sea_->realization->choppiness,
                           fold_search(sea_->budget), map_error(sea_->budget, 0.0)),
                       end_us};
}

void Simulation::surface(TimeUs time_us, Surfaced done) {
    if (const Result<void> fine = check_time(time_us); !fine)
        return done(fine.error());
    ask({[this, time_us, done] {
             const Result<SurfaceSpan> span = surface_around(time_us);
             if (span)
                 done(span->surface);
             else
                 done(span.error());
             return true;
         },
         done});
}

} // namespace seaway::server
