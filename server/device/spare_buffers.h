// SPDX-License-Identifier: Apache-2.0
// Buffers of keyframes that nobody holds any more, kept for the next ones: fresh memory costs a
// page fault every 4 KB, as much time as the maps themselves. What no keyframe has come for is let go of by trim(). Thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "sea/surface/maps/keyframe.h"

namespace seaway::server {

class SpareBuffers {
  public:
    /// Calls of trim() over which a buffer waits for a keyframe: four seconds, where a stream has one every two at the least.
    static constexpr int kept_trims = 8;

    SpareBuffers() { held_.reserve(most_held); } // so that give() never allocates

    /// A buffer of exactly this many values, of any content.
    sea::MapValues::Floats take(std::size_t values) {
        {
            const std::lock_guard lock(mutex_);
            // The last that was given comes first, so that those that are one too many wait on.
            const auto found =
                std::find_if(held_.rbegin(), held_.rend(),
                             [values](const Held& held) { return held.buffer.size() == values; });
            if (found != held_.rend()) {
                sea::MapValues::Floats buffer = std::move(found->buffer);
                held_.erase(std::next(found).base());
                return buffer;
            }
        }
        return sea::MapValues::Floats(values);
    }

    /// Memory that is of use to the next: of keyframes that had none of their own nothing is kept.
    void give(sea::MapValues::Floats buffer) {
        if (buffer.empty())
            return;
        sea::MapValues::Floats oldest; // goes back to the system when others may come in again
        const std::lock_guard lock(mutex_);
        if (held_.size() == most_held) {
            oldest = std::move(held_.front().buffer);
            held_.erase(held_.begin());
        }
        held_.push_back({std::move(buffer), trims_});
    }

    /// Lets go of buffers that have been here for kept_trims of these calls.
    void trim() {
        std::array<sea::MapValues::Floats, most_held> unused; // likewise
        const std::lock_guard lock(mutex_);
        ++trims_;
        const auto kept = std::find_if(held_.begin(), held_.end(), [this](const Held& held) {
            return held.given + kept_trims > trims_;
        });
        std::transform(held_.begin(), kept, unused.begin(),
                       [](Held& held) { return std::move(held.buffer); });
        held_.erase(held_.begin(), kept);
    }
    void clear() {
        const std::lock_guard lock(mutex_);
        held_.clear();
    }

  private:
    static constexpr std::size_t most_held = 8;
    struct Held {
        sea::MapValues::Floats buffer;
        std::int64_t given; ///< after so many trims
    };
    std::mutex mutex_;
    std::vector<Held> held_; ///< the last that was given last
    std::int64_t trims_ = 0;
};

/// A keyframe that gives its values back to `spare` when its last holder lets it go.
inline std::shared_ptr<sea::Keyframe> make_keyframe(const std::shared_ptr<SpareBuffers>& spare) {
    const auto give_back = [spare](sea::Keyframe* keyframe) {
        const std::unique_ptr<sea::Keyframe> owned(keyframe);
        spare->give(owned->values.take());
    };
    return {new sea::Keyframe, give_back};
}

} // namespace seaway::server
