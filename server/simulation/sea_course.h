// SPDX-License-Identifier: Apache-2.0
// SeaCourse: which sea runs when. A function of a log of changes: each glides from the sea of its start to that of its
// scene, and takes over from whatever was to come. So every change is two epochs, the glide and the sea that it leads
// to; the sea that all began with is epoch 1.
//
//     SEAWAY_TRY_LET(SeaCoursePtr course, SeaCourse::begin(scene));     // with its timetable, [[weather]]
//     SEAWAY_TRY(course->add(scene_of_a_storm, start_us, end_us));
//     RunningSeaPtr sea = course->at(time_us);                           // any time, past or future
//
// Each epoch is a sea of its own at any time, so that keyframes around a boundary are there on both sides of it: those
// of one epoch before and behind join to maps without a jump, and at the boundary both seas are one.
//
// Seas are made when they are asked for and let go when others are (seas_kept): a timetable of a month costs no more
// than a calm day. Making one takes about 0.2 s at three cascades of 256 x 256. Thread-safe.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/result.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

/// Epochs that are kept made: the running one, those around it, and some that are asked about. 20 to 40 MB each at
/// three cascades of 256 x 256.
inline constexpr std::size_t seas_kept = 8;
/// Of a log, timetables included.
inline constexpr std::size_t changes_max = 10'000;

/// An epoch runs from start_us on until, without, end_us. Empty: another took over before it began.
struct EpochWindow {
    std::uint32_t epoch;
    sea::TimeUs start_us;
    sea::TimeUs end_us;

    bool empty() const { return end_us <= start_us; }
};

class SeaCourse {
  public:
    /// A course of one sea for ever; it stays made.
    explicit SeaCourse(RunningSeaPtr first);
    /// The sea of a scene and its timetable. An error is one line that names what cannot be had.
    static Result<std::shared_ptr<SeaCourse>> begin(const sea::Scene& scene);

    /// From start_us to end_us over to the sea of `scene`, and on with its timetable. An error says what cannot be, and
    /// then nothing has changed.
    Result<void> add(const sea::Scene& scene, sea::TimeUs start_us, sea::TimeUs end_us);
    /// The error of add(), without adding. Its waves are realised for that.
    Result<void> check(const sea::Scene& scene, sea::TimeUs start_us, sea::TimeUs end_us) const;

    /// The sea that runs at this time.
    RunningSeaPtr at(sea::TimeUs time_us) const;
    /// Of an epoch that there is.
    RunningSeaPtr sea(std::uint32_t epoch) const;
    /// What was said of the running sea when it began: effects, tiles and accuracy of all others too.
    const RunningSeaPtr& first() const { return first_; }

    EpochWindow window_at(sea::TimeUs time_us) const;
    EpochWindow window(std::uint32_t epoch) const;
    /// Those that have not ended at `from_us` and begin before `until_us`, in order of time.
    std::vector<EpochWindow> windows(sea::TimeUs from_us, sea::TimeUs until_us) const;
    std::uint32_t epochs() const;

    /// The scene that the sea of this time is, or glides to.
    sea::Scene scene_at(sea::TimeUs time_us) const;

  private:
    struct Change {
        sea::TimeUs start_us;
        sea::TimeUs end_us;
        sea::Scene scene;
        bool chained =
            false; ///< phases hang on all that was before: waves run otherwise than they did
    };
    struct Epoch {
        sea::TimeUs start_us;
        sea::TimeUs end_us; ///< of its window
        std::size_t change;
        bool glides;
    };

    RunningSeaPtr make(std::uint32_t epoch) const;
    /// Of its scene alone; reads no file.
    RunningSeaPtr steady(const sea::Scene& scene, std::uint32_t epoch) const;
    /// The one that was read at the start, where the scene names it.
    sea::CertificatePtr certificate_of(const sea::Scene& scene) const;
    RunningSeaPtr held(std::uint32_t epoch) const;
    /// Of the first so many epochs.
    std::uint32_t epoch_at(sea::TimeUs time_us, std::size_t epochs) const;
    /// A change and its timetable, or the latter alone, checked; an error names the row.
    Result<std::vector<Change>> changes_to(const sea::Scene& scene, sea::TimeUs start_us,
                                           sea::TimeUs end_us) const;
    Result<std::vector<Change>> timetable(const sea::Scene& scene, sea::TimeUs from_us) const;
    Result<void> check_next(const sea::Scene& from, const sea::Scene& to) const;
    void append(Change change);

    const RunningSeaPtr first_;

    mutable std::recursive_mutex making_; ///< one sea is made at a time
    mutable std::mutex mutex_;            ///< of what follows
    std::vector<Change> changes_;
    std::vector<Epoch> epochs_;              ///< epoch n at n - 1
    mutable std::deque<RunningSeaPtr> kept_; ///< asked for last: at the back
};

using SeaCoursePtr = std::shared_ptr<const SeaCourse>;

/// One sea for ever.
inline SeaCoursePtr steady_course(RunningSeaPtr sea) {
    return std::make_shared<const SeaCourse>(std::move(sea));
}

} // namespace seaway::server
