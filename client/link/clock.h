// SPDX-License-Identifier: Apache-2.0
// Sea time on a client, from pings (base/clock_filter.h), and when these are sent.
#pragma once

#include <cstdint>

#include "base/clock_filter.h"

namespace seaway::client {

using seaway::ClockFilter;
using seaway::ClockStatus;
using seaway::LocalUs;

/// From a ping, the first of a connection is 1, to the next. A burst for a first estimate of the clock; then as many as let the shortest
/// trips of a line that jitters by 20 ms tell the time to half a millisecond within 5 s (tests/load/load_two_clients.cpp); then
/// two a second until half of the clock's window is full, which takes 30 s, and one from there on: who has the waves is sent nothing else.
constexpr LocalUs pause_after_ping_us(std::uint32_t pings_sent) {
    if (pings_sent <= 8)
        return 50'000;
    if (pings_sent <= 48)
        return 100'000;
    return pings_sent <= 100 ? 500'000 : 1'000'000;
}

} // namespace seaway::client
