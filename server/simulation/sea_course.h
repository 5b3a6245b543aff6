// SPDX-License-Identifier: Apache-2.0
// SeaCourse: which sea runs when. A function of a log of changes: each glides from the sea of its start to that of its
// scene, and takes over from whatever was to come, what begins with it included. So every change is two epochs, the glide and the sea that it leads
// to; the sea that all began with is epoch 1.
//
//     SEAWAY_TRY_LET(SeaCoursePtr course, SeaCourse::begin(scene));     // with its timetable, [[weather]]
//     SEAWAY_TRY(course->add(scene_of_a_storm, start_us, end_us));
//     RunningSeaPtr sea = course->at(time_us);                           // any time, past or future
//
// Each epoch is a sea of its own at any time, so that keyframes around a boundary are there on both sides of it: those
// of one epoch before and behind join to maps without a jump, and at the boundary both seas are one.
//
// What another change takes over from before it begins never runs: it keeps its two epochs, whose windows are empty, and
// nothing else is held of it. So a timetable that comes anew each day costs what of it has run, and what is to come.
//
// Seas are made when they are asked for and let go when others are (seas_kept) and nobody holds them: a timetable of a
// month costs no more than a calm day. Making one takes about 0.2 s at three cascades of 256 x 256, a glide twice that, one
// that took over from glides 0.2 s more for each of them. Thread-safe.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/result.h"
#include "server/simulation/course_phases.h"
#include "server/simulation/running_sea.h"

namespace seaway::server {

/// Epochs that are kept made: the running one, those around it, and some that are asked about. 20 to 40 MB each at
/// three cascades of 256 x 256.
inline constexpr std::size_t seas_kept = 8;
/// That have begun or are to come, rows of timetables and the beginning included.
inline constexpr std::size_t changes_max = 10'000;

/// Kinds of add()'s errors; without one: what is wrong with the scene.
enum class CourseError {
    full, ///< there would be more than changes_max
};

/// Glides that take over from glides that have not ended, in a row: each begins with a mixture of all before, which takes
/// 0.2 s more to make.
inline constexpr int takeovers_max = 8;

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
    ~SeaCourse();
    SeaCourse(const SeaCourse&) = delete;
    SeaCourse& operator=(const SeaCourse&) = delete;

    /// From start_us to end_us over to the sea of `scene`, and on with its timetable. An error says what cannot be, and
    /// then nothing has changed; nor where there is no memory (std::bad_alloc).
    ///
    /// `until_us`: when a change takes over that is to be added later, as who reads a log again knows. What would begin
    /// behind that keeps its epochs, and is not looked at.
    Result<void> add(const sea::Scene& scene, sea::TimeUs start_us, sea::TimeUs end_us,
                     sea::TimeUs until_us = std::numeric_limits<sea::TimeUs>::max());
    /// The error of add(), without adding. Its waves are realised for that.
    Result<void> check(const sea::Scene& scene, sea::TimeUs start_us, sea::TimeUs end_us) const;

    /// Where phases hang on all changes before: finds those of the last one, from which those of later ones are found. Some 5 ms
    /// at three cascades of 256 x 256 for each change since it did so; for who adds many, and says between them that it comes on.
    void find_phases() const;

    /// The sea that runs at this time.
    RunningSeaPtr at(sea::TimeUs time_us) const;
    /// Of an epoch that there is; of one that never runs and that nobody holds, the one that took over from it.
    RunningSeaPtr sea(std::uint32_t epoch) const;
    /// Null where it would have to be made.
    RunningSeaPtr sea_if_held(std::uint32_t epoch) const;
    /// Held or made; null where another thread makes one now: as long as is_making(), so that no more than one of those
    /// who answer questions is at it.
    RunningSeaPtr sea_unless_making(std::uint32_t epoch) const;
    bool is_making() const { return is_making_; }
    /// How many have been made since the course began: steady ones, and glides.
    std::uint64_t seas_made() const { return seas_made_; }
    /// Called by who has made some, on his thread. Before anything else is asked; empty: nobody.
    void when_made(std::function<void()> call) const;
    /// What was said of the running sea when it began: effects, tiles and accuracy of all others too.
    const RunningSeaPtr& first() const { return first_; }

    EpochWindow window_at(sea::TimeUs time_us) const;
    EpochWindow window(std::uint32_t epoch) const;
    /// Those that have not ended at `from_us` and begin before `until_us`, in order of time.
    std::vector<EpochWindow> windows(sea::TimeUs from_us, sea::TimeUs until_us) const;
    std::uint32_t epochs() const;
    /// Of changes_max.
    std::size_t changes() const;
    static bool is_glide(std::uint32_t epoch) { return epoch % 2 == 0; }
    /// It is the steady sea behind a change, whose glide is the epoch before.
    static bool ends_a_glide(std::uint32_t epoch) { return epoch > 1 && !is_glide(epoch); }

    /// From when on a change has, or had, waves given by hand, which need not keep to the bands that all seas of the course
    /// share; never: the last time there is.
    sea::TimeUs gives_waves_from_us() const { return gives_waves_from_us_; }

    /// How many glides hang together that one takes over from which begins at this time, each having taken over from the one
    /// before; 0: the sea is steady.
    int glides_in_row(sea::TimeUs time_us) const;

    /// What a sea glides from, and that from, the nearest first; of one that has ended its glide that is enough, whatever it
    /// came from. None of a steady sea.
    std::vector<std::uint32_t> origins(std::uint32_t epoch) const;

    /// The scene that the sea of this time is, or glides to.
    sea::Scene scene_at(sea::TimeUs time_us) const;

  private:
    struct Change;
    using ChangePtr = std::shared_ptr<const Change>;
    /// Immutable; it holds what it takes over from.
    struct Change {
        std::uint32_t number; ///< its epochs are 2 number, the glide, and 2 number + 1
        sea::TimeUs start_us;
        sea::TimeUs end_us;
        sea::Scene scene;
        ChangePtr from = nullptr; ///< the beginning: null
        bool from_glide = false;  ///< which has not ended when this one begins
        /// Waves run otherwise than at the beginning, or have: phases hang on all that was before.
        bool chained = false;

        std::uint32_t epoch(bool glides) const { return 2 * number + (glides ? 0 : 1); }
        std::uint32_t epoch_before() const { return from->epoch(from_glide); }
    };
    struct Row {
        sea::TimeUs start_us;
        sea::TimeUs end_us;
        sea::Scene scene;
    };
    using Changes = std::vector<ChangePtr>;

    /// An epoch that is to be made, and the change that it is of.
    struct Step {
        std::uint32_t epoch;
        ChangePtr change;
    };
    /// A glide begins with the sea that it leaves.
    struct Way {
        RunningSeaPtr from;      ///< null: the first on the way needs none
        std::vector<Step> steps; ///< to be made so that the last one can be, in this order
    };
    Way way_to(std::uint32_t epoch) const;
    RunningSeaPtr made_with(std::unique_lock<std::mutex> turn, std::uint32_t epoch) const;
    void tell_made() const;
    RunningSeaPtr make(const Step& step, const RunningSeaPtr& from) const;
    /// The sea behind a change; reads no file.
    RunningSeaPtr steady(const Change& change) const;
    /// Where the waves of a chained change are when it begins.
    sea::RealizationPtr clocks_before(const Change& change) const;
    /// The one that was read at the start, where the scene names it.
    sea::CertificatePtr certificate_of(const sea::Scene& scene) const;
    RunningSeaPtr hold(RunningSeaPtr sea) const;

    // Of what mutex_ guards, by who holds it.
    /// The last one that has begun by then; that has begun before, which is what one that begins then takes over from.
    Changes::const_iterator change_at(sea::TimeUs time_us) const;
    Changes::const_iterator change_before(sea::TimeUs time_us) const;
    /// Of an epoch; of one that never runs, the one that took over from it.
    Changes::const_iterator change_of(std::uint32_t epoch) const;
    EpochWindow window_of(Changes::const_iterator change, bool glides) const;
    RunningSeaPtr alive(std::uint32_t epoch) const;

    /// A change and its timetable, or the latter alone, checked, without what begins behind `until_us`; an error names the row.
    Result<std::vector<Row>> rows_of(const sea::Scene& scene, sea::TimeUs start_us,
                                     sea::TimeUs end_us, sea::TimeUs until_us) const;
    /// `name_of(row)`: what a row is called where it cannot be.
    using NameOfRow = std::function<std::string(std::size_t row)>;
    Result<std::vector<Row>> timetable(const sea::Scene& scene, sea::TimeUs from_us,
                                       sea::TimeUs until_us, const NameOfRow& name_of) const;
    Result<void> check_next(const sea::Scene& from, const sea::Scene& to) const;
    /// The first of so many changes; the others have numbers alone. Takes over from those before.
    void append(std::vector<Row> rows, std::size_t changes);

    const RunningSeaPtr first_;

    mutable std::mutex making_; ///< one sea is made at a time
    mutable std::atomic<bool> is_making_ = false;
    mutable std::atomic<std::uint64_t> seas_made_ = 0;
    std::atomic<sea::TimeUs> gives_waves_from_us_ = std::numeric_limits<sea::TimeUs>::max();
    mutable CoursePhases phases_;
    mutable std::mutex mutex_; ///< of what follows
    Changes
        changes_; ///< in order of their numbers and of their starts: those that never run are gone
    std::uint32_t last_number_ = 0;          ///< theirs included
    mutable std::deque<RunningSeaPtr> kept_; ///< asked for last: at the back
    mutable std::map<std::uint32_t, std::weak_ptr<const RunningSea>>
        alive_; ///< somebody holds them
    /// Of when_made_, alone: whoever is called may hold a lock under which others ask this course.
    mutable std::mutex telling_;
    mutable std::function<void()> when_made_;
};

using SeaCoursePtr = std::shared_ptr<const SeaCourse>;

/// One sea for ever.
inline SeaCoursePtr steady_course(RunningSeaPtr sea) {
    return std::make_shared<const SeaCourse>(std::move(sea));
}

} // namespace seaway::server
