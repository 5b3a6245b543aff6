// SPDX-License-Identifier: Apache-2.0
// What other servers of a sea say: a change of their log, which is refused or is written again as it was read; and a word about
// clocks, twice, after which this one's place among them is a number and it still answers.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/journal/change_text.h"
#include "server/journal/peer_clocks.h"

using namespace seaway;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(data, data + size);
    if (const auto logged = server::read_message(text)) {
        const std::string written = server::message_of(*logged);
        const auto again = server::read_message(written);
        if (!again || server::message_of(*again) != written || again->change != logged->change)
            std::abort();
        (void)server::check_next(logged->change, again->change);
        (void)server::check_epoch(logged->epoch_utc_us);
    } else if (logged.error().message.empty())
        std::abort();

    server::PeerClocks clocks("here");
    constexpr LocalUs local_us = 10'000'000;
    for (const LocalUs later_us : {LocalUs{0}, server::PeerClocks::every_us}) {
        clocks.hear(text, local_us + later_us, 5'000'000 + later_us);
        const server::PeersSeen seen = clocks.seen(local_us + later_us);
        if (seen.peers > 1 || !std::isfinite(seen.ahead_us) || !(seen.error_us >= 0))
            std::abort();
        if (clocks.word(local_us + later_us, 5'000'000).find("seaway-clock-1 here ") != 0)
            std::abort();
    }
    return 0;
}
