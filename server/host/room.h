// SPDX-License-Identifier: Apache-2.0
// Room: bytes that questions may hold together. What is made for somebody takes room before it is
// made and gives it back when the last of its holders lets it go, on whichever thread; who finds none
// waits, or is refused. So what a crowd of questions holds is bounded. Each is a share of one budget (memory.h).
//
// Thread-safe. Places may outlive the one who asked.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace seaway::server {

class Room : public std::enable_shared_from_this<Room> {
  public:
    /// Held for as long as what it is for.
    using Place = std::shared_ptr<const void>;

    static std::shared_ptr<Room> of(std::size_t bytes_max) {
        return std::shared_ptr<Room>(new Room(bytes_max));
    }

    /// `freed` is called when a place is given back after somebody found no room, on the thread that gives it; null: nothing is,
    /// and no call is under way.
    void on_freed(std::function<void()> freed) {
        const std::scoped_lock lock(mutex_);
        freed_ = std::move(freed);
    }

    /// One always gets what it asks for, however large.
    bool fits(std::size_t bytes) const { return fits(held_, bytes) || fits_after_all(bytes); }
    /// Null: not now.
    Place take(std::size_t bytes) {
        for (std::size_t held = held_;;) {
            if (fits(held, bytes)) {
                if (held_.compare_exchange_weak(held, held + bytes))
                    return taken(bytes, held + bytes);
            } else if (fits_after_all(bytes)) {
                held = held_;
            } else {
                return nullptr;
            }
        }
    }
    /// For who makes room afterwards.
    Place take_anyway(std::size_t bytes) { return taken(bytes, held_ += bytes); }
    bool overfull() const { return held_ > bytes_max_; }

    std::size_t bytes_max() const { return bytes_max_; }
    std::size_t held_bytes() const { return held_; }
    std::size_t held_bytes_most() const { return held_most_; } ///< so far

  private:
    explicit Room(std::size_t bytes_max) : bytes_max_(bytes_max) {}

    bool fits(std::size_t held, std::size_t bytes) const {
        return held == 0 || held + bytes <= bytes_max_;
    }
    /// Looks again once it has said that it lacks room: a place that is given back meanwhile is seen here, or who gives it back sees
    /// that somebody waits.
    bool fits_after_all(std::size_t bytes) const {
        lacked_ = true;
        return fits(held_, bytes);
    }
    Place taken(std::size_t bytes, std::size_t held) {
        for (std::size_t most = held_most_; most < held;)
            held_most_.compare_exchange_weak(most, held);
        return Place(this, [room = shared_from_this(), bytes](const void*) {
            room->held_ -= bytes;
            if (!room->lacked_.exchange(false))
                return; // each answer gives a place back, and nobody is to be woken by it
            const std::scoped_lock lock(room->mutex_);
            if (room->freed_)
                room->freed_();
        });
    }
    const std::size_t bytes_max_;
    std::atomic<std::size_t> held_ = 0;
    std::atomic<std::size_t> held_most_ = 0;
    mutable std::atomic<bool> lacked_ = false; ///< by somebody, since `freed_` was called
    std::mutex mutex_;                         ///< of freed_
    std::function<void()> freed_;
};

/// The same thing, whose holders hold its place too.
template <class T>
std::shared_ptr<const T> with_place(Room::Place place, std::shared_ptr<const T> thing) {
    const auto both = std::make_shared<std::pair<Room::Place, std::shared_ptr<const T>>>(
        std::move(place), std::move(thing));
    return {both, both->second.get()};
}

} // namespace seaway::server
