// SPDX-License-Identifier: Apache-2.0
// SumsRoom: the memory of the exact sums that questions under way keep from slice to slice. A sum that several of them keep has
// one place. Thread-safe.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "sea/waves/reference.h"
#include "server/host/memory.h"

namespace seaway::server {

class SumsRoom {
  public:
    explicit SumsRoom(std::shared_ptr<Room> room) : room_(std::move(room)) {}

    /// Null: there is no room.
    Room::Place take(std::size_t bytes) { return room_->take(bytes); }
    /// Of a sum that others may keep as well; held no longer than the sum is.
    Room::Place take(const std::shared_ptr<const sea::DirectSum>& sum) {
        const std::scoped_lock lock(mutex_);
        std::erase_if(shared_, [](const auto& one) { return one.second.expired(); });
        std::weak_ptr<const void>& known = shared_[sum.get()];
        Room::Place place = known.lock();
        if (!place)
            known = place = room_->take(sum->bytes());
        return place;
    }

    const Room& room() const { return *room_; }

  private:
    const std::shared_ptr<Room> room_;
    std::mutex mutex_;
    std::map<const sea::DirectSum*, std::weak_ptr<const void>> shared_;
};

} // namespace seaway::server
