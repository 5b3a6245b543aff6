// SPDX-License-Identifier: Apache-2.0
// One connection, as far as a client is concerned: what came before it is known whether its sea is the same. Guarded by the
// client's mutex but where it says otherwise.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/result.h"
#include "client/link/clock.h"
#include "sea/basics/pace.h"

namespace seaway::client {

struct Joining {
    struct Look {
        LocalUs sent_us, received_us;
        sea::TimeUs elapsed_us, unsure_us;
    };
    std::vector<Look> looks;
    std::vector<sea::Pace> paces;
    std::uint32_t told_epoch_max = 0; ///< of the seas that it told of
    bool joined = false;
    std::optional<Error> end;
    bool end_told = false; ///< to the program; of the connection's thread alone
};

} // namespace seaway::client
