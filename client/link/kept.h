// SPDX-License-Identifier: Apache-2.0
// Kept: what is wanted of a server until it is said otherwise, so that it can be asked for again. The last wish; where that is
// refused, the last one before it that was granted, or not answered in time: the server may have granted that.
//
// Of several wishes under way replies may come in any order, and of one that is asked for again another one. Not thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

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
    /// That, to be asked for again.
    const One& wanted_one() const { return wanted_; }

    Serial ask(Wish wish) {
        wanted_ = {std::move(wish), ++last_};
        return last_;
    }
    /// Nothing is wanted any more, whatever is granted yet of what was asked for before.
    void end() {
        wanted_ = granted_ = open_ = {};
        ended_ = last_;
    }

    void granted(Serial serial, const Wish& wish) {
        if (serial <= ended_ || serial < granted_.serial)
            return;
        granted_ = {wish, serial};
        if (serial > wanted_.serial) // one that came after it was refused
            wanted_ = granted_;
    }
    void failed(Serial serial, const Wish& wish, const Error& why) {
        if (why.is(Failure::deadline)) {
            if (serial > ended_ && serial > open_.serial)
                open_ = {wish, serial};
            return;
        }
        if (serial == open_.serial)
            open_ = {};
        if (serial == wanted_.serial)
            wanted_ = open_.serial > granted_.serial ? open_ : granted_;
    }

  private:
    One wanted_, granted_;
    One open_;         ///< not answered in time
    Serial last_ = 0;  ///< asked for
    Serial ended_ = 0; ///< the last one before an end
};

} // namespace seaway::client
