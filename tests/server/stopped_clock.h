// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "server/journal/sea_clock.h"

namespace seaway::server {

/// A clock on which it is always that time.
inline SeaClock stopped_at(sea::TimeUs now_us) {
    return SeaClock(
        0, [now_us] { return now_us; }, [] { return 0; });
}

} // namespace seaway::server
