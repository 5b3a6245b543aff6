// SPDX-License-Identifier: Apache-2.0
// Surfaces: the sea around a time, made of keyframes that are held, as splines or as maps. Any thread makes them of what is
// there; what is not there is made by the one thread that has the device (make_keyframes), slice by
// slice, and the surface is finished by whoever asked for it. A surface that somebody uses is shared by
// all who ask about its times.
//
// Surfaces is thread-safe; a SurfaceJob is one thread's at a time.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "base/result.h"
#include "sea/surface/surface.h"
#include "server/host/memory.h"
#include "server/simulation/keyframe_source.h"

namespace seaway::server {

using SurfacePtr = std::shared_ptr<const sea::Surface>;

/// Who waits for whose memory.
enum class SurfaceUse {
    batch,  ///< for long: waits while others hold the room there is
    prompt, ///< has a room apart
    few,    ///< prompt, for a slice or two: waits for no room where all is held and nothing is made
    ahead,  ///< of the server itself, one at a time: waits for no room
};

/// What a slice may do that takes long.
enum class Make {
    what_lacks,
    nothing, ///< some microseconds of looking for what is there
};

/// The surface around a time, and how far it has come.
class SurfaceJob {
  public:
    /// Of some cascades alone, one at least: the others are neither made nor held.
    explicit SurfaceJob(sea::TimeUs time_us, SurfaceUse use = SurfaceUse::batch,
                        std::uint32_t cascades = sea::all_cascades)
        : time_us_(time_us), use_(use), cascades_(cascades) {}

    /// Once Surfaces::work_on() has said that it is there. Whoever holds it holds its room.
    const SurfacePtr& surface() const { return surface_; }
    /// It holds its times up to, without, this one.
    sea::TimeUs end_us() const { return end_us_; }
    /// The next slice is one of Surfaces::make_keyframes().
    bool lacks_keyframes() const { return lacks_keyframes_; }

  private:
    friend class Surfaces;

    const sea::TimeUs time_us_;
    const SurfaceUse use_;
    const std::uint32_t cascades_;
    bool lacks_keyframes_ = false;
    bool awaits_room_ = false;
    bool awaits_sea_ = false;
    bool awaits_spline_ = false; ///< that another thread makes
    Room::Place place_;
    /// A keyframe, as maps of which a spline is to be made or as that spline.
    struct Part {
        KeyframeRequest of;
        sea::KeyframePtr maps;
        sea::SplineMapPtr spline;
        bool lacks() const { return maps == nullptr && spline == nullptr; }
    };
    std::vector<Part> found_;              ///< two a cascade, with those that lack
    std::optional<KeyframeJob> keyframes_; ///< these
    std::vector<Part> parts_;              ///< the same once none lacks, else none
    SurfacePtr surface_;
    sea::TimeUs end_us_ = 0;
};

class Surfaces {
  public:
    Surfaces(SeaCoursePtr course, KeyframeSource& source, const Memory& memory);

    /// One slice, a spline at most; true: the surface is there. Else the job lacks keyframes, waits for
    /// room or for the spline of another, or needs another slice.
    bool work_on(SurfaceJob& job, Make make = Make::what_lacks);
    /// Held by who makes a spline, which takes some ms: no other thread begins one, so that of several threads one
    /// at most is lost to who comes with a single point. Null: somebody holds it.
    std::shared_ptr<const void> spline_turn();
    /// One slice of the keyframes that the job lacks; on the source's thread.
    Result<void> make_keyframes(SurfaceJob& job);

    /// A slice would come to nothing: others hold the room, or another thread makes a sea or a spline.
    bool waits(const SurfaceJob& job) const {
        return (job.awaits_sea_ && course_->is_making()) ||
               (job.awaits_room_ && !job.place_ && !room_of(job).fits(bytes_)) ||
               (job.awaits_spline_ && splining_);
    }

  private:
    struct Used {
        std::uint32_t epoch;
        std::uint32_t cascades;
        sea::TimeUs start_us;
        sea::TimeUs end_us;
        std::weak_ptr<const sea::Surface> surface;
    };

    bool has_sea(SurfaceJob& job, Make make);
    bool share(SurfaceJob& job);
    bool look_up(SurfaceJob& job);
    bool take_room(SurfaceJob& job, bool anyway);
    /// What is held of these now.
    std::vector<SurfaceJob::Part> found(const std::vector<KeyframeRequest>& wanted);
    /// One at most; true: all are there.
    bool make_splines(SurfaceJob& job, Make make);
    /// False: the keyframes are of a sea that does not run then any more; to be looked for again.
    bool finish(SurfaceJob& job);
    std::vector<KeyframeRequest> wanted(const SurfaceJob& job) const;
    Room& room_of(const SurfaceJob& job) const {
        return job.use_ == SurfaceUse::batch ? *batches_ : *prompt_;
    }

    const SeaCoursePtr course_;
    KeyframeSource& source_;
    const std::size_t bytes_; ///< of one
    const std::shared_ptr<Room> batches_;
    const std::shared_ptr<Room> prompt_;

    std::atomic<bool> splining_ = false;
    std::mutex mutex_;       ///< of what follows
    std::vector<Used> used_; ///< by somebody, now or a while ago
};

} // namespace seaway::server
