// SPDX-License-Identifier: Apache-2.0
// Kept: what is wanted of a server until it is said otherwise, so that it can be asked for again. The last wish; where that is
// refused, the last one before it that was granted, or not answered in time: the server may have granted that. Of those that were
// not answered in time the last few count.
//
// Of several wishes under way replies may come in any order, and of one that is asked for again another one. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "client/link/failure.h"

namespace seaway::client {

template <class Wish>
class Kept {
  public:
    using Serial = std::uint64_t; ///< tells a wish from those before and after
    struct One {
        std::optional<Wish> wish;
        Serial serial = 0;
    };

    const std::optional<Wish>& wanted() const { return wanted_.wish; }
    /// Has another been asked for since, or none any more?
    bool is_past(Serial serial) const { return serial != last_ || is_over(serial); }
    /// Has there been an end since?
    bool is_over(Serial serial) const { return serial <= ended_; }
    /// That, to be asked for again.
    const One& wanted_one() const { return wanted_; }

    /// Whoever asked for it: there is nothing to be asked for again.
    bool is_granted_on(int connection) const {
        return wanted_.wish && wanted_.serial == granted_.serial && granted_on_ == connection;
    }

    Serial ask(Wish wish) {
        open_.reserve(open_max + 1); // a reply that comes too late takes no memory
        wanted_ = {std::move(wish), ++last_};
        return last_;
    }
    /// Nothing is wanted any more, whatever is granted yet of what was asked for before.
    void end() {
        wanted_ = granted_ = {};
        open_.clear();
        ended_ = last_;
    }

    /// `connection`: the number of the one that it was granted on, from 1 on, where that matters.
    void granted(Serial serial, const Wish& wish, int connection = 0) {
        if (serial <= ended_ || serial < granted_.serial)
            return;
        granted_ = {wish, serial};
        granted_on_ = connection;
        std::erase_if(open_, [&](const One& one) { return one.serial <= serial; });
        if (serial > wanted_.serial) // one that came after it was refused
            wanted_ = granted_;
    }
    void failed(Serial serial, const Wish& wish, const Error& why) {
        if (why.is(Failure::deadline)) {
            const auto after = std::ranges::lower_bound(open_, serial, {}, &One::serial);
            if (serial <= ended_ || serial < granted_.serial ||
                (after != open_.end() && after->serial == serial))
                return;
            open_.insert(after, {wish, serial});
            if (open_.size() > open_max)
                open_.erase(open_.begin());
            return;
        }
        std::erase_if(open_, [&](const One& one) { return one.serial == serial; });
        if (serial == wanted_.serial)
            wanted_ = open_.empty() ? granted_ : open_.back();
    }

  private:
    static constexpr std::size_t open_max = 8;

    One wanted_, granted_;
    std::vector<One> open_; ///< not answered in time, by serial; later than what was granted
    int granted_on_ = 0;
    Serial last_ = 0;  ///< asked for
    Serial ended_ = 0; ///< the last one before an end
};

} // namespace seaway::client
