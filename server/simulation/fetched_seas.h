// SPDX-License-Identifier: Apache-2.0
// FetchedSeas: the seas that keyframes around some times are of, and those that their foam remembers: made, one a slice, by
// a thread that has no stream to serve, before the thread that has asks the device for the keyframes. They are left to the
// course, which keeps a few: who waits must not fill the memory with them. Where foam remembers more than are kept, the first
// would be gone before the walk came to them: each is made when it does, and a few are held, by the one fetch that walks.
// One thread's at a time.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "sea/basics/field.h"
#include "server/simulation/sea_course.h"

namespace seaway::server {

/// Which seas these are, each once, in order. Foam remembers no further back than it walks.
std::vector<std::uint32_t> fetched_epochs(const SeaCourse& course,
                                          std::span<const sea::TimeUs> times_us,
                                          sea::FieldSet fields);

class FetchedSeas {
  public:
    /// The course outlives it. Nothing is made yet.
    FetchedSeas(const SeaCourse& course, std::span<const sea::TimeUs> times_us,
                sea::FieldSet fields);

    bool are_there() const { return there_ == epochs_.size(); }
    /// The next one.
    void make_some();
    /// One that is needed now, and held until two others have been; false: another thread makes one.
    bool make(std::uint32_t epoch);
    /// Holds those no longer.
    void let_go() { used_ = {}; }
    /// Another thread makes one now.
    bool wait() const { return awaits_ && course_.is_making(); }

  private:
    const SeaCourse& course_;
    std::vector<std::uint32_t> epochs_;
    std::size_t there_ = 0; ///< of the first epochs
    bool awaits_ = false;
    /// By make(), the last one first: foam at the end of its keyframe's sea is of the next one.
    std::array<RunningSeaPtr, 2> used_;
};

} // namespace seaway::server
