// SPDX-License-Identifier: Apache-2.0
// Buffers of keyframes that nobody holds any more, kept for the next ones: fresh memory costs a
// page fault every 4 KB, as much time as the maps themselves. Thread-safe.
#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "sea/surface/maps/keyframe.h"

namespace seaway::server {

class SpareBuffers {
  public:
    SpareBuffers() { held_.reserve(most_held); } // so that give() never allocates

    /// A buffer of exactly this many values, of any content.
    sea::MapValues::Floats take(std::size_t values) {
        {
            const std::lock_guard lock(mutex_);
            for (sea::MapValues::Floats& held : held_) {
                if (held.size() != values)
                    continue;
                sea::MapValues::Floats found = std::move(held);
                held = std::move(held_.back());
                held_.pop_back();
                return found;
            }
        }
        return sea::MapValues::Floats(values);
    }

    /// Memory that is of use to the next: of keyframes that had none of their own nothing is kept.
    void give(sea::MapValues::Floats buffer) {
        if (buffer.empty())
            return;
        const std::lock_guard lock(mutex_);
        if (held_.size() < most_held)
            held_.push_back(std::move(buffer));
        else
            std::swap(held_[oldest_++ % most_held], buffer);
    }

    void clear() {
        const std::lock_guard lock(mutex_);
        held_.clear();
    }

  private:
    static constexpr std::size_t most_held = 8;
    std::mutex mutex_;
    std::vector<sea::MapValues::Floats> held_;
    std::size_t oldest_ = 0;
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
