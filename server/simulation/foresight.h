// SPDX-License-Identifier: Apache-2.0
// Foresight: who asks about now over and over is going to ask about what follows. The surface of a
// little later is then made ready ahead, so that nobody waits for splines where one keyframe follows another;
// whoever asks once, or about other times, has nothing made for it.
//
// Thread-safe.
#pragma once

#include <mutex>
#include <optional>

#include "sea/basics/time.h"

namespace seaway::server {

class Foresight {
  public:
    /// So much later than what was asked about; less than what keyframes of a stream are published ahead.
    static constexpr sea::TimeUs ahead_us = 200'000;
    /// From one look ahead to the next.
    static constexpr sea::TimeUs step_us = 20'000;
    /// What is called now, and over and over.
    static constexpr sea::TimeUs about_us = 1'000'000;

    /// Somebody asks about a time. The time whose surface is worth making ready, if any.
    std::optional<sea::TimeUs> asked(sea::TimeUs time_us, sea::TimeUs now_us);

  private:
    std::mutex mutex_;
    std::optional<sea::TimeUs> last_now_us_; ///< when somebody asked about now
    sea::TimeUs ready_us_ = 0;               ///< up to here it has been said
};

} // namespace seaway::server
