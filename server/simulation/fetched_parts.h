// SPDX-License-Identifier: Apache-2.0
// FetchedParts: a fetch of keyframes, sea by sea. Of each that runs at some of its times the sea is made first, by threads
// that have no stream to serve; then the keyframes are, by the thread that has the device: so no more than one sea of a
// fetch must be there at a time, however many it asks for (SeaCourse keeps a few). It goes back to those threads wherever the
// next slice is of a sea that nobody holds, as in a walk of foam through many. One thread's at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "server/simulation/fetched_seas.h"
#include "server/simulation/keyframe_source.h"
#include "server/simulation/questions.h"
#include "server/simulation/schedule.h"

namespace seaway::server {

class FetchedParts {
  public:
    /// The course outlives it. Parts take their bytes of `room` (KeyframeJob).
    FetchedParts(const SeaCourse& course, const std::vector<sea::TimeUs>& times_us,
                 const Demand& demand, std::shared_ptr<Room> room);

    /// Who does the next slice: what makes some of a sea, or what works on the job.
    Hand hand() const {
        return seas_->are_there() && !lacks_sea() ? Hand::simulation : Hand::answers;
    }
    /// Asked before work on the job. False: its sea was let go while this waited in line, and is made again first.
    bool may_work();
    /// A slice would come to nothing now.
    bool waits() const { return seas_->wait() || (job_ && job_->waits()); }

    void make_some_sea();
    /// Keyframes of the sea whose turn it is, which is there.
    KeyframeJob& job();
    /// What of the job is made, once KeyframeSource::work_on() has said so. After its last part it is the next sea's turn.
    std::vector<sea::KeyframePtr> take();
    bool complete() const { return next_ == seas_of_times_.size(); }

  private:
    void begin();
    bool lacks_sea() const { return job_ && job_->lacks_sea(); }
    std::uint32_t epoch() const { return course_.window_at(seas_of_times_[next_].front()).epoch; }

    const SeaCourse& course_;
    const Demand demand_;
    const std::shared_ptr<Room> room_;
    std::vector<std::vector<sea::TimeUs>> seas_of_times_; ///< times of each sea, in order of epochs
    std::size_t next_ = 0;
    std::optional<FetchedSeas> seas_;
    std::optional<KeyframeJob> job_;
};

} // namespace seaway::server
