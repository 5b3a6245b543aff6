// SPDX-License-Identifier: Apache-2.0
// HeldGlides: the glides that were asked about last, with the seas that they are made of. One of 256 x 256 x 3 takes some 20 MB, and 20
// more for each of its last three times, and is made anew within some tens of ms; so few are held.
//
// One caller at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "client/rebuilt/rebuilt_sea.h"

namespace seaway::client {

/// The sea that a glide leads to, and those before it, back to where the first glide began that had not ended when the next one did.
using GlideEnds = std::vector<OwnSeaPtr>;

class HeldGlides {
  public:
    static constexpr std::size_t held_max = 4;

    /// The glide of this epoch if it was made of these; else null.
    OwnSeaPtr find(std::uint32_t epoch, const GlideEnds& ends);
    /// In the place of another of its epoch, or of the one that was asked about least recently. `end_us`: then it ends.
    void keep(std::uint32_t epoch, sea::TimeUs end_us, const GlideEnds& ends, OwnSeaPtr sea);
    /// Lets go of those that have ended by then and were not asked about since this was called last: their epochs.
    std::vector<std::uint32_t> let_go_ended(sea::TimeUs now_us);
    void forget(std::uint32_t epoch);
    void clear() { glides_.clear(); }

  private:
    struct Glide {
        std::uint32_t epoch = 0;
        sea::TimeUs end_us = 0;
        std::vector<std::weak_ptr<const OwnSea>> ends;
        OwnSeaPtr sea;
        bool asked_about = true;
    };
    std::vector<Glide> glides_; ///< the one that was asked about last is the last
};

} // namespace seaway::client
