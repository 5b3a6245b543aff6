// SPDX-License-Identifier: Apache-2.0
// Options of programs that have tiles streamed over thin lines: fewer keyframes, smaller maps.
#pragma once

#include "base/command_line.h"
#include "base/result.h"
#include "protocol/messages.h"

namespace seaway::client {

struct TileLimits {
    double rate_hz_max = 0; ///< 0: none
    int size_max = 0;       ///< 0: none

    void describe(CommandLine& line);
    Result<void> check() const;
    void put_into(protocol::TileWish& wish) const;
};

} // namespace seaway::client
