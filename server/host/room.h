// SPDX-License-Identifier: Apache-2.0
// Room: bytes that questions may hold together. What is made for somebody takes room before it is
// made and gives it back when the last of its holders lets it go, on whichever thread; who finds none
// waits. So what a crowd of questions holds is bounded, and none of them is refused for it.
//
// take() and fits() are for one thread; all else is thread-safe. Places may outlive the one who asked.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>

namespace seaway::server {

class Room : public std::enable_shared_from_this<Room> {
  public:
    /// Held for as long as what it is for.
    using Place = std::shared_ptr<const void>;

    /// `freed` is called after each place that is given back, on the thread that does; not after
    /// forget().
    static std::shared_ptr<Room> of(std::size_t bytes_max, std::function<void()> freed) {
        return std::shared_ptr<Room>(new Room(bytes_max, std::move(freed)));
    }

    /// One always gets what it asks for, however large.
    bool fits(std::size_t bytes) const { return held_ == 0 || held_ + bytes <= bytes_max_; }
    /// Null: not now.
    Place take(std::size_t bytes) {
        if (!fits(bytes))
            return nullptr;
        held_ += bytes;
        held_most_ = std::max(held_most_.load(), held_.load());
        return Place(this, [room = shared_from_this(), bytes](const void*) {
            room->held_ -= bytes;
            const std::scoped_lock lock(room->mutex_);
            if (room->freed_)
                room->freed_();
        });
    }
    void forget() {
        const std::scoped_lock lock(mutex_);
        freed_ = nullptr;
    }

    std::size_t held_bytes() const { return held_; }
    std::size_t held_bytes_most() const { return held_most_; } ///< so far

  private:
    Room(std::size_t bytes_max, std::function<void()> freed)
        : bytes_max_(bytes_max), freed_(std::move(freed)) {}

    const std::size_t bytes_max_;
    std::atomic<std::size_t> held_ = 0;
    std::atomic<std::size_t> held_most_ = 0;
    std::mutex mutex_; ///< of freed_
    std::function<void()> freed_;
};

} // namespace seaway::server
