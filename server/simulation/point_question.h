// SPDX-License-Identifier: Apache-2.0
// PointQuestion: a batch of points, each at its own time, answered slice by slice in order of time,
// so that points which share keyframes stand together. One thread's at a time.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sea/surface/answer.h"
#include "sea/waves/reference.h"
#include "server/simulation/questions.h"
#include "server/simulation/sums_room.h"
#include "server/simulation/surfaces.h"

namespace seaway::server {

/// Says that a slice has lasted long enough; asked after each point, of which a slice has one at
/// least. What a point takes depends on the sea: an exact one 10 us to 0.1 s.
using SliceOver = std::function<bool()>;
/// By the clock, from now on. A single point that comes waits for no more than what is left of a slice.
inline constexpr std::chrono::microseconds points_slice{200};
SliceOver over_after(std::chrono::steady_clock::duration time);

/// Refusal::bad_value, with value and range, for times and places where no sea is computed. A place
/// that is not a number is let through: its answer says so.
Result<void> check_time(sea::TimeUs time_us);
Result<void> check_point(const sea::QueryPoint& point);

struct PointsAsked {
    PointsAsked(std::vector<sea::QueryPoint> points_) // NOLINT(google-explicit-constructor)
        : points(std::move(points_)) {}

    std::vector<sea::QueryPoint> points; ///< that have passed check_point()
    bool exact = false;                  ///< by the direct sum
    sea::Looking looking = {};
    /// None, or one a point: the water there as well (sea/surface/below.h), always by the direct sum.
    std::vector<double> z_m = {};
};

/// In the order of the points.
struct PointsAnswered {
    std::vector<sea::Answer> answers;
    std::vector<sea::WaterBelow> below; ///< one a depth
};

/// The cascades of a sea that are left, a bit each; all_cascades where none is left out, whatever was asked. All seas of a course
/// have the same ones.
std::uint32_t felt_cascades(const sea::Realization& sea, const sea::Looking& looking);

/// The same of all seas of a course that these points are of. From where a change gives waves by hand all are felt: how long those
/// are is not known before that sea is made.
std::uint32_t felt_cascades(const SeaCourse& course, std::span<const sea::QueryPoint> points,
                            const sea::Looking& looking);

class PointQuestion {
  public:
    /// `cascades`: which of them count.
    explicit PointQuestion(PointsAsked asked, SurfaceUse use = SurfaceUse::batch,
                           std::uint32_t cascades = sea::all_cascades);

    /// Who is to do the next slice: the simulation where make_keyframes() is to be called.
    Hand hand() const {
        return surface_ && surface_->lacks_keyframes() ? Hand::simulation : Hand::answers;
    }
    /// One slice: the next points, at least one, from the surface around them, or a slice of making
    /// that surface.
    void sample(Surfaces& surfaces, const SliceOver& over, Make make = Make::what_lacks);
    /// A slice of the keyframes that the next surface lacks.
    Result<void> make_keyframes(Surfaces& surfaces) { return surfaces.make_keyframes(*surface_); }
    /// The same as sample() by the direct sum. From one slice to the next it keeps the waves of its time where `sums` has room
    /// for them and for whatever of their sea the course may let go, and makes them anew where not.
    void sum_exactly(const SeaCourse& course, const SliceOver& over, SumsRoom& sums);

    /// A slice would come to nothing, for want of room for the next surface or of the sea of the next point.
    bool waits(const Surfaces& surfaces, const SeaCourse& course) const {
        return (surface_ && surfaces.waits(*surface_)) || (awaits_sea_ && course.is_making());
    }

    /// What a question of so many points holds.
    static std::size_t bytes_of(std::size_t points, std::size_t depths = 0) {
        return points * (sizeof(sea::QueryPoint) + sizeof(std::size_t) + sizeof(sea::Answer)) +
               depths * (sizeof(double) + sizeof(sea::WaterBelow));
    }

    bool complete() const { return done_count_ == order_.size(); }
    PointsAnswered take_answers() { return std::move(answered_); }

  private:
    const sea::QueryPoint& next() const { return asked_.points[order_[done_count_]]; }
    /// The next ones before `end_us`, one at least and `most` at most.
    void put_some(const sea::Surface& surface, sea::TimeUs end_us, std::size_t most);
    void put(const sea::Answer& answer) { answered_.answers[order_[done_count_++]] = answer; }
    /// Of a sea of which nothing is felt.
    void lie_flat();
    sea::Answer exactly(const sea::QueryPoint& point);
    /// False: their sea is not there yet.
    bool take_waves(const SeaCourse& course, sea::TimeUs time_us);
    void let_go_waves();

    const PointsAsked asked_;
    const SurfaceUse use_;
    const std::uint32_t cascades_;
    std::vector<std::size_t> order_; ///< by time
    PointsAnswered answered_;
    std::size_t done_count_ = 0;        ///< of `order_`
    std::optional<SurfaceJob> surface_; ///< around the next one
    bool awaits_sea_ = false;
    // At moment_us_; of the sea itself no more is kept.
    sea::Choppiness choppiness_;
    sea::FoldSearch folds_;
    std::shared_ptr<const sea::DirectSum> truth_;
    std::optional<sea::DirectSum::Moment> moment_; ///< of truth_
    sea::TimeUs moment_us_ = 0;
    Room::Place moment_place_, truth_place_; ///< the second where the course need not keep it
};

} // namespace seaway::server
