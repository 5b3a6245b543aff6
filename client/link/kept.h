// SPDX-License-Identifier: Apache-2.0
// Kept: what is wanted of a server until it is said otherwise, so that it can be asked for again. The last wish; where that is
// refused, the one that was granted last. A reply that does not come in time refuses nothing: the server may have granted it.
//
// Of several wishes under way replies may come in any order. Not thread-safe.
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

    const std::optional<Wish>& wanted() const { return wanted_.wish; }

    Serial ask(Wish wish) {
        wanted_ = {std::move(wish), ++last_};
        return last_;
    }
    /// Nothing is wanted any more, whatever is granted yet of what was asked for before.
    void end() {
        wanted_ = granted_ = {};
        ended_ = last_;
    }

    void granted(Serial serial, const Wish& wish) {
        if (serial <= ended_ || serial < granted_.serial)
            return;
        granted_ = {wish, serial};
        if (serial > wanted_.serial) // one that came after it was refused
            wanted_ = granted_;
    }
    void failed(Serial serial, const Error& why) {
        if (serial == wanted_.serial && !why.is(Failure::deadline))
            wanted_ = granted_;
    }

  private:
    struct One {
        std::optional<Wish> wish;
        Serial serial = 0;
    };
    One wanted_, granted_;
    Serial last_ = 0;  ///< asked for
    Serial ended_ = 0; ///< the last one before an end
};

} // namespace seaway::client
