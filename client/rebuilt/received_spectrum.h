// SPDX-License-Identifier: Apache-2.0
// ReceivedSpectrum: the waves of one sea as a server sends them. What has come can be asked at any time, and knows
// how far it is from the whole sea.
//
// Thread-safe. A sea that has got more waves since it was last asked for is made anew: some milliseconds.
#pragma once

#include <mutex>
#include <optional>
#include <span>

#include "client/link/connection.h"
#include "client/rebuilt/rebuilt_sea.h"
#include "sea/waves/spectrum_builder.h"

namespace seaway::client {

class ReceivedSpectrum {
  public:
    /// `head` has passed check().
    ReceivedSpectrum(SeaStatePtr state, const protocol::SpectrumHead& head);

    /// A chunk. Errors: what SpectrumBuilder does not take, a sea that is too large among it, and more chunks than `head` says.
    Result<void> add(const sea::SpectrumLeft& left, std::span<const sea::WaveBlock> blocks);

    /// Null before the first waves.
    RebuiltSeaPtr sea() const;
    bool has_come() const; ///< sea() would be one

    /// What is still missed of a height, one standard deviation in metres; infinite before the first waves.
    double left_m() const;

    const SeaStatePtr& state() const { return state_; }

  private:
    sea::RealizationPtr waves() const; ///< making_ held

    const SeaStatePtr state_;
    mutable std::mutex making_; ///< of the next four, for as long as a sea takes; before mutex_
    mutable Result<sea::SpectrumBuilder> builder_;
    std::uint32_t chunks_to_come_;
    mutable sea::RealizationPtr all_; ///< taken from builder_ once all has come: it is held once
    mutable RebuiltSeaPtr sea_;       ///< of what has come; null: to be made anew
    mutable std::mutex mutex_;        ///< of what is left, which is asked for without waiting
    std::optional<sea::SpectrumLeft> left_;
};

} // namespace seaway::client
